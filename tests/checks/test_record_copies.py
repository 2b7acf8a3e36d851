"""Copies of records are found in the C that Cython writes."""

from checks.record_copies import copies

C = """
typedef npy_int64 __pyx_t_5numpy_int64_t;
struct __pyx_t_1a_1b_Curve {
  double value[2 * 3];
};
struct __pyx_t_1a_1b_View {
  struct __pyx_t_1a_1b_Span values;
};
struct __pyx_t_1a_1b_Span {
  double *at;
};
static double __pyx_f_1a_1b_by_value(struct __pyx_t_1a_1b_Curve __pyx_v_curve); /*proto*/
static double __pyx_f_1a_1b_by_value(struct __pyx_t_1a_1b_Curve __pyx_v_curve, CYTHON_UNUSED int __pyx_v_n) {
  struct __pyx_t_1a_1b_Curve *__pyx_v_pointer;
  struct __pyx_t_1a_1b_Curve __pyx_v_several[2];
  struct __pyx_t_1a_1b_Curve __pyx_t_2;
  struct __pyx_t_1a_1b_Curve __pyx_v_found;
  struct __pyx_t_1a_1b_View __pyx_v_view;
  __pyx_ctuple_double__and_double __pyx_v_pair;
  __pyx_t_5numpy_int64_t __pyx_v_k;
  unsigned long long __pyx_v_bits;
  int64_t __pyx_v_whole;
  enum __pyx_t_1a_1b_Kind __pyx_v_kind;
  /* "a/b.pxi":3 */
}
static PyObject *__pyx_pf_1a_1b_4run(PyObject *__pyx_v_self) {
  Vec __pyx_v_of_a_header;
}
"""


def test_locals_and_arguments_that_are_structs_are_found():
    assert list(copies(C, "a.b")) == [
        ("by_value", "curve", "Curve"),
        ("by_value", "found", "Curve"),
        ("run", "of_a_header", "Vec"),
    ]
