"""Damage to text files, as editors, disks and other programs do it."""

NUMBERS = (b"nan", b"-nan", b"inf", b"1e308", b"-1e40", b"0", b"-1", b"99999999999999999999", b"x")


def damaged(text, random):
    """A file with one to three random damages.

    Args:
        text: Its content (bytes).
        random: Generator of random numbers.
    """
    for _ in range(random.integers(1, 4)):
        if len(text) < 2:
            break
        text = DAMAGES[random.integers(len(DAMAGES))](text, random)
    return text


def _number(text, random):
    """Another number, or none, in place of one."""
    lines = text.split(b"\n")
    k = random.integers(len(lines))
    words = lines[k].split(b" ")
    words[random.integers(len(words))] = NUMBERS[random.integers(len(NUMBERS))]
    lines[k] = b" ".join(words)
    return b"\n".join(lines)


def _word_lost(text, random):
    """A word less in a line."""
    lines = text.split(b"\n")
    k = random.integers(len(lines))
    words = lines[k].split(b" ")
    del words[random.integers(len(words))]
    lines[k] = b" ".join(words)
    return b"\n".join(lines)


def _line_lost(text, random):
    """A line less."""
    lines = text.split(b"\n")
    del lines[random.integers(len(lines))]
    return b"\n".join(lines)


def _line_twice(text, random):
    """A line more, the same as another."""
    lines = text.split(b"\n")
    lines.insert(random.integers(len(lines)), lines[random.integers(len(lines))])
    return b"\n".join(lines)


def _lines_swapped(text, random):
    """Two lines in each other's place."""
    lines = text.split(b"\n")
    i, j = random.integers(len(lines), size=2)
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def _bits_flipped(text, random):
    """Some bytes changed."""
    content = bytearray(text)
    for at in random.integers(len(content), size=random.integers(1, 9)):
        content[at] ^= 1 << int(random.integers(8))
    return bytes(content)


def _cut_short(text, random):
    """Only the beginning."""
    return text[: random.integers(1, len(text))]


def _block_lost(text, random):
    """A piece less."""
    i, j = sorted(random.integers(len(text), size=2))
    return text[: i + 1] + text[min(j, i + 2000) :]


DAMAGES = (
    *3 * (_number,),  # the damage that is hardest to see
    _word_lost,
    _line_lost,
    _line_twice,
    _lines_swapped,
    _bits_flipped,
    _cut_short,
    _block_lost,
)
