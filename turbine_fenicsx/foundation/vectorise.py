"""Kernels of FFCx for several cells together: C code in which a number is a register of numbers.

A kernel computes one cell with numbers one after the other, and its loops over the nodes of a cell
fill registers badly. Here each number becomes one number for each of several cells, its lanes, so
that all arithmetic of the kernel uses whole registers. The statements are those of FFCx, in the
same order.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

HEAD = re.compile(r"^void tabulate_tensor_integral_\w+\([^()]*\)\n(?=\{)", re.MULTILINE)
STATEMENT = re.compile(
    r"\s*(?:for \([^)]*\)|static const double [^;]*;|double \w+(?:\[\d+\])+ = \{[^;]*;"
    r"|[^;{}\s][^;{}]*;|[{}])"
)
ARRAY = re.compile(r"(?:const )?double (\w+(?:\[\d+\])+(?: = \{0(?:\.0)?\})?);")
NUMBER = re.compile(r"(?:const )?double (\w+) = ([^;]*);")
CONDITION = re.compile(r"bool (\w+) = ([^;]*);")
ASSIGNMENT = re.compile(r"(\w+(?:\[.*?\])*) (=|\+=) ([^;]*);", re.DOTALL)
FUNCTION = re.compile(r"\b([a-z]\w*)\(")
COMPARISON = re.compile(r" (<=|>=|==|!=|<|>) ")
ONE_BY_ONE = ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh")
"""Functions of one argument that are computed lane by lane."""

NOT_THERE = re.compile(r"\b(entity_local_index|quadrature_permutation|custom_data)\b|&&|\|\|")


class NotVectorised(Exception):
    """The code has something that is not known here; DOLFINx runs it cell by cell."""


@dataclass(frozen=True)
class Registers:
    """Registers of a processor.

    Args:
        target: Instructions that the compiler may use besides those that every processor has.
        flags: What Linux calls them; a processor must have all of them.
    """

    lanes: int
    target: str
    flags: frozenset[str]


REGISTERS = (
    Registers(8, "avx512f,avx512dq,fma", frozenset(("avx512f", "avx512dq", "fma"))),
    Registers(4, "avx2,fma", frozenset(("avx2", "fma"))),
    Registers(2, "", frozenset()),
)
"""The widest first."""


def find_registers(processors: str) -> int:
    """Index into `REGISTERS` of the widest ones that a processor has.

    Args:
        processors: What Linux says of it, the text of /proc/cpuinfo.
    """
    found = re.search(r"^flags\s*:(.*)$", processors, re.MULTILINE)
    flags = set(found[1].split()) if found else set()
    return next(k for k, registers in enumerate(REGISTERS) if registers.flags <= flags)


@dataclass(frozen=True)
class Field:
    """A field as cells see it."""

    nodes: int
    block: int

    @property
    def size(self) -> int:
        """Numbers in a cell."""
        return self.nodes * self.block


DECLARATION = """void assemble(long cells, const int32_t *nodes, const double *x,
    const int32_t *const *dofs, const double *const *values, const double *c,
    const int32_t *rows, double *out);"""
"""Add the vectors of the cells of a register to ``out``: nodes of cells and positions ``x`` of the
mesh, degrees of freedom and values of each coefficient, constants, degrees of freedom of the
vector."""


def assembly_code(ffcx: str, geometry: Field, coefficients: Sequence[Field], vector: Field) -> str:
    """C code of `DECLARATION`, with the macros LANES and TARGET for `Registers` to be set before.

    Args:
        ffcx: C code of FFCx with the kernel of one integral over cells of a linear form.
        coefficients: The coefficients in the order of the kernel.
    """
    kernels = list(find_kernels(ffcx))
    if len(kernels) != 1:
        raise NotVectorised(f"{len(kernels)} kernels")
    gathers, offset = [], 0
    for k, field in enumerate(coefficients):
        gathers.append(
            f"        gather(w + {offset}, values[{k}], dofs[{k}], cell, {field.nodes}, "
            f"{field.block});"
        )
        offset += field.size
    return (
        _FRAME.replace("KERNEL", vectorise_kernel(kernels[0]))
        .replace("GATHERS", "\n".join(gathers))
        .replace("DECLARATION", DECLARATION.rstrip(";"))
        .replace("FUNCTIONS", "\n".join(_ONE_BY_ONE.replace("NAME", f) for f in ONE_BY_ONE))
        .replace("WIDTH", str(max(1, offset)))
        .replace("NODES", str(geometry.nodes))
        .replace("ROWS", str(vector.nodes))
        .replace("BLOCK", str(vector.block))
    )


def find_kernels(ffcx: str) -> Iterator[str]:
    """The bodies of all kernels in C code of FFCx, in braces."""
    for head in HEAD.finditer(ffcx):
        depth = 0
        for brace in re.finditer("[{}]", ffcx[head.end() :]):
            depth += 1 if brace.group() == "{" else -1
            if depth == 0:
                yield ffcx[head.end() : head.end() + brace.end()]
                break


def vectorise_kernel(body: str) -> str:
    """The body of a kernel, in braces, with V for double."""
    text = re.sub(r"//[^\n]*", "", body)
    found = [m.group() for m in STATEMENT.finditer(text)]
    if "".join("".join(found).split()) != "".join(text.split()):
        raise NotVectorised("a statement that does not end")
    return "\n".join(map(_statement, found))


def _statement(text: str) -> str:
    """Vectorise a statement."""
    text = text.strip()
    if text in ("{", "}") or text.startswith(("for (", "static const double ")):
        return text
    if NOT_THERE.search(text):
        raise NotVectorised(text)
    if found := ARRAY.fullmatch(text):
        return f"V {found[1]};"
    if found := NUMBER.fullmatch(text):
        return f"V {found[1]} = ZERO + ({_expression(found[2])});"
    if found := CONDITION.fullmatch(text):
        return f"I {found[1]} = {_condition(found[2])};"
    if found := ASSIGNMENT.fullmatch(text):
        return f"{found[1]} {found[2]} ZERO + ({_expression(found[3])});"
    raise NotVectorised(text)


def _expression(text: str) -> str:
    """Vectorise an expression: functions and choices get new names."""
    while "?" in text:
        text = _vectorise_choice(text)
    for name in FUNCTION.findall(text):
        if name not in (*ONE_BY_ONE, "fabs", "pow"):
            raise NotVectorised(text)
    return FUNCTION.sub(r"LANES_\1(", text)


def _vectorise_choice(text: str) -> str:
    """The last choice ``condition ? a : b`` of an expression as a function of these three."""
    middle = text.rindex("?")
    begin = _end_of_part(text, range(middle - 1, -1, -1), ")", "(,") + 1
    colon = _end_of_part(text, range(middle + 1, len(text)), "(", ":)")
    end = _end_of_part(text, range(colon + 1, len(text)), "(", "),")
    condition, a, b = text[begin:middle], text[middle + 1 : colon], text[colon + 1 : end]
    return f"{text[:begin]}CHOOSE({_condition(condition)}, {a}, {b}){text[end:]}"


def _end_of_part(text: str, places: range, deeper: str, ends: str) -> int:
    """The first place outside all brackets with one of the characters ``ends``; or the last."""
    depth, closing = 0, "(" if deeper == ")" else ")"
    for place in places:
        if depth == 0 and text[place] in ends:
            return place
        depth += (text[place] == deeper) - (text[place] == closing)
    return places.stop


def _condition(text: str) -> str:
    """Vectorise a comparison, or the name of one."""
    parts = COMPARISON.split(text.strip())
    if len(parts) == 1:
        return parts[0]
    if len(parts) != 3 or "?" in text:
        raise NotVectorised(text)
    a, relation, b = parts
    return f"(I)(ZERO + ({_expression(a)}) {relation} ZERO + ({_expression(b)}))"


_ONE_BY_ONE = """FAST V lanes_NAME(V x)
{ V y; for (int l = 0; l < LANES; l++) y[l] = NAME(x[l]); return y; }
#define LANES_NAME(x) lanes_NAME(ZERO + (x))"""

_FRAME = """#include <math.h>
#include <stdint.h>
typedef double V __attribute__((vector_size(8 * LANES)));
typedef int64_t I __attribute__((vector_size(8 * LANES)));
#define ZERO ((V){0})
#define FAST TARGET static inline __attribute__((always_inline))
FUNCTIONS
FAST V lanes_fabs(V x) { return (V)((I)x & ~((I){0} + INT64_MIN)); }
#define LANES_fabs(x) lanes_fabs(ZERO + (x))
FAST V lanes_pow(V x, V y)
{ V z; for (int l = 0; l < LANES; l++) z[l] = pow(x[l], y[l]); return z; }
#define LANES_pow(x, y) lanes_pow(ZERO + (x), ZERO + (y))
FAST V choose(I which, V a, V b) { return (V)((which & (I)a) | (~which & (I)b)); }
#define CHOOSE(which, a, b) choose(which, ZERO + (a), ZERO + (b))

TARGET static void tabulate(V *restrict A, const V *restrict w, const double *restrict c,
                            const V *restrict coordinate_dofs)
KERNEL

FAST void gather(V *into, const double *values, const int32_t *dofs, const long *cell,
                 int nodes, int block)
{
    for (int l = 0; l < LANES; l++)
        for (int i = 0; i < nodes; i++) {
            const double *at = values + (long)block * dofs[cell[l] * nodes + i];
            for (int k = 0; k < block; k++)
                into[i * block + k][l] = at[k];
        }
}

TARGET DECLARATION
{
    V X[3 * NODES], w[WIDTH], A[ROWS * BLOCK];
    long cell[LANES];
    for (long first = 0; first < cells; first += LANES) {
        int n = cells - first < LANES ? cells - first : LANES;
        for (int l = 0; l < LANES; l++)
            cell[l] = first + (l < n ? l : 0);
        gather(X, x, nodes, cell, NODES, 3);
GATHERS
        for (int i = 0; i < ROWS * BLOCK; i++)
            A[i] = ZERO;
        tabulate(A, w, c, X);
        for (int l = 0; l < n; l++)
            for (int i = 0; i < ROWS; i++) {
                double *at = out + (long)BLOCK * rows[cell[l] * ROWS + i];
                for (int k = 0; k < BLOCK; k++)
                    at[k] += A[i * BLOCK + k][l];
            }
    }
}
"""
