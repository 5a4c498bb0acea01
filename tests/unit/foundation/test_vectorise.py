"""Vectorised statements of FFCx; `system/test_linear_form.py` tests the numbers."""

import re

import pytest

from turbine_fenicsx.foundation.vectorise import (
    REGISTERS,
    Field,
    NotVectorised,
    assembly_code,
    find_kernels,
    find_registers,
    vectorise_kernel,
)

KERNEL = """{
  // a comment; with { what } is no statement
  static const double weights_1[2] = { 0.5,
     0.5 };
static const double FE[1][1][1][2] = {{{{0.5, 0.5}}}};
  double sv_1[3];
  double temp[8] = {0};
  for (int iq = 0; iq < 2; ++iq)
  {
double J = 0.0;
    J += w[3 * (iq) + 1] * FE[0][0][0][iq];
    const double fw0 = sv_1[2] * weights_1[iq];
    A[(3 * (iq) + 1)] += fw0;
}
}"""


def vectorised(statement):
    return " ".join(vectorise_kernel("{\n" + statement + "\n}").split()[1:-1])


def test_tables_and_loops_stay_and_all_other_numbers_get_lanes():
    found = re.sub(r"\s+", " ", vectorise_kernel(KERNEL))
    assert found == (
        "{ static const double weights_1[2] = { 0.5, 0.5 }; "
        "static const double FE[1][1][1][2] = {{{{0.5, 0.5}}}}; "
        "V sv_1[3]; V temp[8] = {0}; for (int iq = 0; iq < 2; ++iq) { V J = ZERO + (0.0); "
        "J += ZERO + (w[3 * (iq) + 1] * FE[0][0][0][iq]); "
        "V fw0 = ZERO + (sv_1[2] * weights_1[iq]); A[(3 * (iq) + 1)] += ZERO + (fw0); } }"
    )


def test_functions_and_choices_get_names_of_their_own():
    assert vectorised("double a = sqrt(pow(b, 2)) / fabs(c[0]);") == (
        "V a = ZERO + (LANES_sqrt(LANES_pow(b, 2)) / LANES_fabs(c[0]));"
    )
    assert vectorised("bool t = a + b > 4e-06;") == "I t = (I)(ZERO + (a + b) > ZERO + (4e-06));"
    assert vectorised("double a = t ? b : 1.0;") == "V a = ZERO + (CHOOSE(t, b , 1.0));"
    choice = vectorised("s[1] = s[2] / ((a + b) * c > 4e-6 ? a + b : (t > 1 ? c : 1.0));")
    assert choice.count("CHOOSE(") == 2 and "?" not in choice
    assert choice.startswith(
        "s[1] = ZERO + (s[2] / (CHOOSE((I)(ZERO + ((a + b) * c) > ZERO + (4e-6"
    )


def test_a_choice_ends_with_the_argument_of_a_function():
    assert vectorised("double a = pow(t ? b : c, 2);") == (
        "V a = ZERO + (LANES_pow(CHOOSE(t, b , c), 2));"
    )
    assert vectorised("double a = pow(b, t ? 2 : 3);") == (
        "V a = ZERO + (LANES_pow(b,CHOOSE(t, 2 , 3)));"
    )


@pytest.mark.parametrize(
    "statement",
    [
        "double a = FE[0][entity_local_index[0]][0][0];",
        "double a = erf(b);",
        "bool t = a > b && c > b;",
        "double a = t ? b : c; while (a) a = b;",
        "float a = 1.0;",
        "double a = 1.0",
    ],
)
def test_what_is_not_known_is_not_guessed(statement):
    with pytest.raises(NotVectorised):
        vectorised(statement)


def test_a_kernel_ends_with_its_last_brace_however_it_is_indented():
    code = (
        f"// x\nvoid tabulate_tensor_integral_a(double* restrict A,\n  void* custom)\n{KERNEL}\n"
        "bool enabled[1] = {1};\n"
        "void tabulate_tensor_integral_b(double* restrict A)\n{\n}\n"
    )
    assert list(find_kernels(code)) == [KERNEL, "{\n}"]
    with pytest.raises(NotVectorised, match="2 kernels"):
        assembly_code(code, Field(8, 3), [], Field(8, 3))


def test_registers_are_those_that_the_processor_has():
    words = "processor : 0\nflags\t\t: fpu sse2 {}\nbugs : none\n"
    assert [
        REGISTERS[find_registers(text)].lanes
        for text in (
            words.format("avx2 fma avx512f avx512dq"),
            words.format("avx2 fma avx512f"),
            words.format("avx2"),
            "Features : fp asimd\n",
        )
    ] == [8, 4, 2, 2]
