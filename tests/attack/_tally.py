"""What became of the tries of an attack."""

from collections import Counter
from dataclasses import dataclass, field


@dataclass
class Tally:
    """Counts of the ways in which tries held, and a sentence for each that did not."""

    held: Counter = field(default_factory=Counter)
    broken: list = field(default_factory=list)

    def hold(self, how):
        """A try held, in one of a few ways such as "refused by a sentence"."""
        self.held[how] += 1

    def break_(self, sentence):
        """A try broke something; the sentence says which and how, to repeat it."""
        self.broken.append(sentence)


def report(name, title, tally, seconds):
    """Lines to print."""
    tries = sum(tally.held.values()) + len(tally.broken)
    lines = [f"{name}: {title}"]
    lines.append(f"  {tries} tries, {len(tally.broken)} broken, {seconds:.0f} s of CPU time")
    lines += [f"  {count:6d} {how}" for how, count in tally.held.most_common()]
    lines += [f"  BROKEN {sentence}" for sentence in tally.broken[:50]]
    return "\n".join(lines)
