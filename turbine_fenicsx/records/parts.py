"""Names of the parts of ``fields.xdmf``, and what carries them.

The cell field ``part`` distinguishes the parts by their numbers, the point field ``coupling`` says
by which coupling a point is held. This is the rest that a picture needs, as text inside the file.
"""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from turbine_fenicsx.foundation.errors import InputError


@dataclass(frozen=True)
class Part:
    """One part.

    Args:
        number: Its value of the cell field ``part``.
        body: Body that it is, or that it is a piece of; the pieces of a body share their colours.
        stands_on: For a rigid part, the number of the coupling by which a flexible body carries it,
            through any joints and rigid bodies in between; 0 for none. None for a flexible part.
    """

    number: int
    name: str
    body: str
    stands_on: int | None = None


@dataclass(frozen=True)
class Parts:
    """All parts.

    Args:
        parts: The parts.
        roots: Couplings whose rigid body, or ground, carries the flexible body: their numbers, and
            for each the coupling that this rigid body stands on, as in `Part`. All other couplings
            carry a rigid body.
    """

    parts: tuple[Part, ...]
    roots: dict[int, int] = field(default_factory=dict)

    def to_text(self) -> str:
        """As text."""
        return json.dumps(asdict(self))

    @classmethod
    def from_text(cls, text: str) -> "Parts":
        """From `to_text`.

        Raises:
            InputError: if it is something else.
        """
        try:
            data: dict[str, Any] = json.loads(text)
            roots = {int(number): int(on) for number, on in data["roots"].items()}
            return cls(tuple(Part(**part) for part in data["parts"]), roots)
        except (KeyError, TypeError, AttributeError):
            raise InputError(f"{text[:60]!r} does not describe parts") from None

    def numbers(self, *names: str) -> list[int]:
        """Numbers of the parts of these names."""
        return [part.number for part in self.parts if part.name in names]
