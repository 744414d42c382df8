// Group laws of the grid symmetries, and the classes of the octahedral group.
#include <array>

#include "core/octahedral_rotation.hpp"
#include "core/quarter_turn.hpp"
#include "core/testing.hpp"

using namespace neurframe;
using Integers3 = Vector3<std::int64_t>;

static void test_quarter_turns() {
  const Vector2<std::int64_t> x{3, 5};
  CHECK(QuarterTurn(1)(x) == (Vector2<std::int64_t>{-5, 3}));
  for (int a = -4; a < 8; ++a) {
    CHECK(QuarterTurn(a).inverse()(QuarterTurn(a)(x)) == x);
    for (int b = 0; b < 4; ++b)
      CHECK((QuarterTurn(a) * QuarterTurn(b))(x) == QuarterTurn(a)(QuarterTurn(b)(x)));
  }
}

static void test_plane_transitions() {
  const std::int64_t one = 16;
  const Vector2<std::int64_t> x{7, -9};
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) {
      const GridTransition2 first{QuarterTurn(a), {2, -3}};
      const GridTransition2 second{QuarterTurn(b), {-1, 4}};
      CHECK((second * first)(x, one) == second(first(x, one), one));
      CHECK(first.inverse()(first(x, one), one) == x);
      CHECK(first * first.inverse() == GridTransition2{});
    }
  }
}

static int determinant_of(OctahedralRotation r) {
  const Integers3 a = r(Integers3{1, 0, 0});
  const Integers3 b = r(Integers3{0, 1, 0});
  const Integers3 c = r(Integers3{0, 0, 1});
  return static_cast<int>(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]));
}

static void test_octahedral_group() {
  const Integers3 x{2, 3, 7};
  std::array<int, 4> kinds{};
  for (int i = 0; i < 24; ++i) {
    const OctahedralRotation a(i);
    CHECK(determinant_of(a) == 1);
    CHECK(a.inverse()(a(x)) == x);
    ++kinds[static_cast<std::size_t>(a.kind())];
    for (int j = 0; j < 24; ++j) {
      const OctahedralRotation b(j);
      CHECK((a * b)(x) == a(b(x)));
      CHECK((i == j) == (a(x) == b(x)));
    }
  }
  CHECK(kinds == (std::array<int, 4>{1, 6, 3, 14}));
}

static void test_axes() {
  for (int i = 0; i < 24; ++i) {
    const OctahedralRotation r(i);
    if (r.kind() != RotationKind::quarter_turn && r.kind() != RotationKind::half_turn) {
      CHECK(r.fixed_axis() == -1 && r.quarter_turn_sign() == 0);
      continue;
    }
    const auto axis = static_cast<std::size_t>(r.fixed_axis());
    Integers3 along{0, 0, 0};
    Integers3 first{0, 0, 0};
    Integers3 second{0, 0, 0};
    along[axis] = first[(axis + 1) % 3] = second[(axis + 2) % 3] = 1;
    CHECK(r(along) == along);
    CHECK((r.quarter_turn_sign() == 1) == (r(first) == second));
    CHECK((r.quarter_turn_sign() == -1) == (r(second) == first));
    CHECK((r.kind() == RotationKind::half_turn) == ((r * r).is_identity()));
  }
}

static void test_space_transitions() {
  const Integers3 x{7, -9, 33};
  for (int i = 0; i < 24; ++i) {
    const GridTransition3 first{OctahedralRotation(i), {1, -2, 5}};
    const GridTransition3 second{OctahedralRotation(23 - i), {0, 8, -3}};
    CHECK((second * first)(x, std::int64_t{16}) == second(first(x, std::int64_t{16}), std::int64_t{16}));
    CHECK(first.inverse()(first(x, std::int64_t{16}), std::int64_t{16}) == x);
    CHECK(first.inverse() * first == GridTransition3{});
  }
}

int main() {
  test_quarter_turns();
  test_plane_transitions();
  test_octahedral_group();
  test_axes();
  test_space_transitions();
  return test_result();
}
