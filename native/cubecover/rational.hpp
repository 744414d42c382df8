// Exact small fractions: the coefficients of the eliminated constraints are 0, +-1 and, beside singular
// edges, +-1/2.
#pragma once

#include <cstdint>
#include <numeric>
#include <stdexcept>

namespace neurframe {

struct Rational {
  std::int64_t numerator = 0;
  std::int64_t denominator = 1;  // positive, coprime to the numerator

  Rational() = default;
  Rational(std::int64_t value) : numerator(value) {}  // NOLINT: integers are fractions
  Rational(std::int64_t n, std::int64_t d) {
    if (d == 0) throw std::domain_error("fraction with denominator zero");
    const std::int64_t divisor = std::gcd(n, d) * (d < 0 ? -1 : 1);
    numerator = n / divisor;
    denominator = d / divisor;
  }
  bool is_zero() const { return numerator == 0; }
  bool is_unit() const { return denominator == 1 && (numerator == 1 || numerator == -1); }
  double value() const { return static_cast<double>(numerator) / static_cast<double>(denominator); }
};

inline std::int64_t checked_product(std::int64_t a, std::int64_t b) {
  std::int64_t product = 0;
  if (__builtin_mul_overflow(a, b, &product)) throw std::overflow_error("fraction exceeds 64 bits");
  return product;
}

inline std::int64_t checked_sum(std::int64_t a, std::int64_t b) {
  std::int64_t sum = 0;
  if (__builtin_add_overflow(a, b, &sum)) throw std::overflow_error("fraction exceeds 64 bits");
  return sum;
}

inline Rational operator*(const Rational& a, const Rational& b) {
  const std::int64_t cross_ab = std::gcd(a.numerator, b.denominator);
  const std::int64_t cross_ba = std::gcd(b.numerator, a.denominator);
  return {checked_product(a.numerator / cross_ab, b.numerator / cross_ba),
          checked_product(a.denominator / cross_ba, b.denominator / cross_ab)};
}

inline Rational operator+(const Rational& a, const Rational& b) {
  return {
      checked_sum(checked_product(a.numerator, b.denominator), checked_product(b.numerator, a.denominator)),
      checked_product(a.denominator, b.denominator)};
}

inline Rational operator-(const Rational& a) {
  return {-a.numerator, a.denominator};
}
inline Rational operator/(const Rational& a, const Rational& b) {
  return a * Rational(b.denominator, b.numerator);
}
inline bool operator==(const Rational& a, const Rational& b) {
  return a.numerator == b.numerator && a.denominator == b.denominator;
}

}  // namespace neurframe
