// What doubles claim about points, columns and facets, against exact arithmetic: a filter may leave a
// question open, but never answer it wrongly.
#include <algorithm>
#include <random>

#include "core/extraction/corner_planes.hpp"
#include "core/extraction/facet_prints.hpp"
#include "core/extraction/lattice_points.hpp"
#include "core/extraction/locate_points.hpp"
#include "core/extraction/recover_transitions.hpp"
#include "core/testing.hpp"

using namespace neurframe;

// One simplex of a few cells, some of them slivers on or near the lattice, some far from the origin.
template <int N>
static GridMap<N> random_simplex(std::mt19937_64& random) {
  GridMap<N> map;
  map.fraction_bits = fixed_default_fraction_bits;
  map.P.resize(1);
  do {
    const Fixed origin = map.one() * static_cast<Fixed>(random() % 3 * 20000);
    const Fixed grain = std::array<Fixed, 3>{1, map.one() / 2, map.one()}[random() % 3];
    for (auto& corner : map.P[0]) {
      for (Fixed& x : corner) x = origin + static_cast<Fixed>(random()) % (4 * map.one()) / grain * grain;
    }
    if (random() % 3 == 0) map.P[0][N] = map.P[0][0];
    if (random() % 3 == 0) map.P[0][N][0] += 1;
  } while (signed_measure(map.P[0]) == 0);
  map.orientation = {static_cast<std::int8_t>(sign_of(signed_measure(map.P[0])))};
  map.twin.assign(N + 1, -1);
  return map;
}

// True when no certain bit contradicts the exact signs.
template <int N>
static bool agree(const CertainSides<N>& sides, const FacetSigns<N>& signs) {
  for (std::size_t facet = 0; facet <= N; ++facet) {
    if (((sides.inside >> facet) & 1u) != 0 && signs[facet] <= 0) return false;
    if (((sides.outside >> facet) & 1u) != 0 && signs[facet] >= 0) return false;
  }
  return true;
}

template <int N>
static void test_sides(std::mt19937_64& random) {
  int certain = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const GridMap<N> map = random_simplex<N>(random);
    const SimplexPlanes<N> planes(map, 0);
    const CornerPlanes<N> corners(planes, map.one() / 2);
    const LatticeBox<N> box = lattice_box(map, 0, 0);
    const FixedPoint<N> p = lattice_point<N>(box.low, map.one(), 0);
    CHECK(agree<N>(certain_sides(map, 0, p), exact_facet_signs(map, 0, p)));
    for (const FixedPoint<N>& corner : map.P[0]) {  // on N facets: only the opposite one can be certain
      const CertainSides<N> sides = certain_sides(map, 0, corner);
      CHECK(agree<N>(sides, exact_facet_signs(map, 0, corner)));
      certain += sides.inside != 0 ? 1 : 0;
    }
    for (int corner = 0; corner < cell_corners<N>; ++corner) {
      FixedPoint<N> q = p;
      for (std::size_t k = 0; k < N; ++k) q[k] += diagonal<N>(corner)[k] * (map.one() / 2);
      CHECK(agree<N>(corners.sides(corners.values(p), corner), exact_facet_signs(map, 0, q)));
    }
  }
  CHECK(certain > 300);  // of 300 (N + 1), slivers left out: the filter is of use
}

template <int N>
static void test_columns(std::mt19937_64& random) {
  int inside = 0;
  int certain = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const GridMap<N> map = random_simplex<N>(random);
    const SimplexPlanes<N> planes(map, 0);
    const LatticeBox<N> box = lattice_box(map, 0, 0);
    for_each_column<N>(planes, box, map.one(), 0, [&](LatticeIndex<N> index, const ColumnRange& range) {
      for (index[N - 1] = box.low[N - 1]; index[N - 1] <= box.high[N - 1]; ++index[N - 1]) {
        const auto signs = exact_facet_signs(map, 0, lattice_point<N>(index, map.one(), 0));
        const bool candidate = range.begin <= index[N - 1] && index[N - 1] < range.end;
        CHECK(candidate || !none_negative(signs));
        CHECK(all_positive(signs) || !range.certainly_inside(index[N - 1]));
        inside += all_positive(signs) ? 1 : 0;
        certain += range.certainly_inside(index[N - 1]) ? 1 : 0;
      }
    });
  }
  CHECK(inside > 0);
  CHECK(2 * certain > inside);
}

template <int N>
static void test_location(std::mt19937_64& random) {
  for (int trial = 0; trial < 300; ++trial) {
    const GridMap<N> map = random_simplex<N>(random);
    const FixedPoint<N> p = lattice_point<N>(lattice_box(map, 0, 0).low, map.one(), 0);
    const Location<N> location = locate(map, 0, p);
    for (std::size_t i = 0; i <= N; ++i) {
      auto replaced = map.P[0];
      replaced[i] = p;
      const double whole = static_cast<double>(signed_measure(map.P[0]));
      CHECK(location.weights[i] == static_cast<double>(signed_measure(replaced)) / whole);
    }
  }
}

// Facets as two charts see them, thick and thin, exact and not: the short cut chooses as the search does.
static void test_transitions(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-4.0, 4.0);
  int unrivalled = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    detail::FacetParameters<3> a;
    for (RealPoint<3>& u : a) u = {uniform(random), uniform(random), uniform(random)};
    if (trial % 3 == 0) a[1] = {a[0][0] + 1.0, a[0][1], a[0][2]};
    if (trial % 5 == 0) a[2] = a[trial % 2 == 0 ? 0 : 1];
    const double noise = std::array<double, 3>{0.0, 1e-5, 0.3}[static_cast<std::size_t>(trial % 7 % 3)];
    detail::FacetParameters<3> b;
    for (std::size_t k = 0; k < 3; ++k) {
      b[k] = OctahedralRotation(trial % 24)(a[k]);
      for (double& x : b[k]) x += 5.0 + noise * uniform(random);
    }
    const detail::RowMisfits misfits = detail::row_misfits(a, b);
    const auto searched = detail::best_of<3>(detail::rotation_residuals(misfits), a, b);
    const auto chosen = detail::best_transition(a, b);
    CHECK(chosen.rotation == searched.rotation);
    CHECK(chosen.residual == searched.residual);
    CHECK(chosen.ambiguous == searched.ambiguous);
    CHECK(chosen.translation == searched.translation);
    double residual = 0.0;
    unrivalled += detail::unrivalled_rotation(misfits, residual) >= 0 ? 1 : 0;
  }
  CHECK(unrivalled > 500);
  CHECK(unrivalled < 2000);
}

// Two hexes side by side, and what the prints say when one of them is there twice or upside down.
static void test_prints() {
  const CellVertices<3> left{0, 1, 4, 3, 6, 7, 10, 9};
  const CellVertices<3> right{1, 2, 5, 4, 7, 8, 11, 10};
  const auto repeated = [](const std::vector<CellVertices<3>>& cells) {
    return repeated_facet_prints<3>(cells, 12, 1).size();
  };
  CHECK(repeated({left, right}) == 0);
  CHECK(repeated({left, right, right}) == 6);
  const CellVertices<3> turned{2, 5, 4, 1, 8, 11, 10, 7};  // a quarter turn: the same facets
  CHECK(repeated({left, right, turned}) == 6);
  const CellVertices<3> mirrored{7, 8, 11, 10, 1, 2, 5, 4};  // all facets from their other side
  CHECK(repeated({right, mirrored}) == 0);
  CHECK(repeated({left, right, mirrored}) == 1);  // the facet between is seen twice from the left
  CHECK(repeated_facet_prints<2>({{0, 1, 3, 2}, {1, 4, 5, 3}}, 6, 1).empty());
  CHECK(repeated_facet_prints<2>({{0, 1, 3, 2}, {0, 1, 5, 4}}, 6, 1).size() == 1);
}

int main() {
  std::mt19937_64 random(1);
  test_sides<2>(random);
  test_sides<3>(random);
  test_columns<2>(random);
  test_columns<3>(random);
  test_location<2>(random);
  test_location<3>(random);
  test_transitions(random);
  test_prints();
  return test_result();
}
