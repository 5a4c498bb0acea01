"""Files of compiled forms as FFCx writes them, without a compiler, for tests of their cache."""

import hashlib
from types import SimpleNamespace

FORM = "libffcx_forms_1"


def compiled(folder, claim=lambda name: None, name=FORM):
    """What FFCx does: it writes the files of a form and returns the code with its module."""
    claim(name)
    for suffix in (".c", ".o", ".so", ".c.cached"):
        (folder / f"{name}{suffix}").touch()
    return "code", SimpleNamespace(__file__=str(folder / f"{name}.abi3.so")), ()


def sealed(folder):
    """A form that was compiled, with its checksum."""
    compiled(folder)
    digest = hashlib.blake2b(b"", digest_size=16).hexdigest()
    (folder / f"{FORM}.seal").write_text(digest)


def no_locks(file, operation):
    """What a file system without locks answers."""
    raise OSError(95, "Operation not supported")


def files(folder):
    return sorted(path.name for path in folder.iterdir())
