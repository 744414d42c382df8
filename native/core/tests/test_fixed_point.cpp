// Exactness of the determinants at the documented bounds.
#include "core/fixed_point.hpp"
#include "core/testing.hpp"

using namespace neurframe;

static void test_fraction_bits() {
  CHECK(fraction_bits_for(0.0) == 24);
  CHECK(fraction_bits_for(65000.0) == 24);
  CHECK(fraction_bits_for(65535.0) == 23);
  CHECK(fraction_bits_for(16'000'000.0) == 16);
  CHECK(fraction_bits_for(17'000'000.0) == 0);
  CHECK(fraction_bits_for(std::nan("")) == 0);
  CHECK(fraction_bits_for(INFINITY) == 0);
}

static void test_rounding() {
  CHECK(to_fixed(1.0, 24) == (Fixed{1} << 24));
  CHECK(to_fixed(-0.5, 24) == -(Fixed{1} << 23));
  for (const double x : {0.1, -3.7, 1234.56789}) {
    CHECK_NEAR(from_fixed(to_fixed(x, 24), 24), x, std::ldexp(0.5, -24));
  }
}

// A determinant whose value is known and needs 126 bits: 6 * 2^123 from entries of +-2^41 in the pattern of
// largest determinant for 3x3 (Hadamard bound for +-1 matrices is 4, so 4 * 2^123).
static void test_largest_determinant() {
  const Fixed m = Fixed{1} << 41;
  const Int128 expected = Int128{4} * (Int128{1} << 123);
  CHECK(determinant({-m, m, m}, {m, -m, m}, {m, m, -m}) == expected);
  CHECK(determinant({m, -m, m}, {-m, m, m}, {m, m, -m}) == -expected);
}

// One unit in the last place decides: a double evaluation cannot see it.
static void test_last_bit() {
  const Fixed m = (Fixed{1} << 40) - 1;
  CHECK(sign_of(orient2d({-m, -m}, {m, m}, {m - 1, m})) == 1);
  CHECK(sign_of(orient2d({-m, -m}, {m, m}, {m, m - 1})) == -1);
  CHECK(sign_of(orient2d({-m, -m}, {m, m}, {m - 1, m - 1})) == 0);
  CHECK(sign_of(orient3d({-m, -m, -m}, {m, m, 0}, {0, m, m}, {-m, -m, -m + 1})) == 1);
  CHECK(sign_of(orient3d({-m, -m, -m}, {m, m, m}, {m - 1, m, m}, {m - 2, m, m})) == 0);
  CHECK(sign_of(orient3d({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1})) == 1);
}

int main() {
  test_fraction_bits();
  test_rounding();
  test_largest_determinant();
  test_last_bit();
  return test_result();
}
