"""Program that holds a Bladed-style controller, so that only it ends where the library ends it.

It imports nothing but the standard library. Requests come on stdin, replies go to the file
descriptor of the last argument; what the library prints goes to stdout.

    python discon_child.py LIBRARY INPUT NAME DESCRIPTOR

A request is a number of records, then so many pairs (number of the record, value); a reply is the
flag of the library, then the values of `REPLIES`, the length of a message, and the message.
"""

import ctypes
import os
import struct
import sys

REPLIES = (42, 43, 44, 45, 47, 48)
"""Records that the library sets: pitch of three blades, collective pitch, torque, yaw rate."""

SIZE = 3300
"""Records of the swap array."""

TEXT = 1024
"""Length of messages."""

NO_LIBRARY = 3
"""Exit code where the library cannot be loaded, with the reason on stderr."""

COUNT, PAIR = struct.Struct("<i"), struct.Struct("<if")
REPLY = struct.Struct(f"<i{len(REPLIES)}fi")


def main(library: str, infile: str, name: str, descriptor: str) -> int:
    """Answer requests until there are no more."""
    try:
        discon = ctypes.CDLL(library).DISCON
    except (OSError, AttributeError) as error:
        print(error, file=sys.stderr)
        return NO_LIBRARY
    discon.restype = None
    swap = (ctypes.c_float * SIZE)()
    failed = ctypes.c_int(0)
    path, root = infile.encode(), name.encode()
    message = ctypes.create_string_buffer(TEXT)
    requests = sys.stdin.buffer
    with os.fdopen(int(descriptor), "wb") as replies:
        while len(head := requests.read(COUNT.size)) == COUNT.size:
            for record, value in PAIR.iter_unpack(requests.read(COUNT.unpack(head)[0] * PAIR.size)):
                swap[record - 1] = value
            # lengths of the texts with their end, Bladed's records 49 to 51 and 64
            for record, length in ((49, TEXT), (50, len(path) + 1), (51, len(root) + 1)):
                swap[record - 1] = length
            swap[63] = TEXT
            failed.value = 0
            discon(swap, ctypes.byref(failed), path, root, message)
            text = message.value.strip()
            values = [swap[record - 1] for record in REPLIES]
            replies.write(REPLY.pack(failed.value, *values, len(text)) + text)
            replies.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
