// Adjacency of triangle and tet meshes, edge rings, and the complaints about bad meshes.
#include <set>

#include "core/edge_rings.hpp"
#include "core/testing.hpp"
#include "core/tet_mesh.hpp"
#include "core/triangle_mesh.hpp"

using namespace neurframe;

static void test_triangles() {
  const std::vector<Triangle> F{{0, 1, 2}, {2, 1, 3}};
  const std::vector<int> twin = half_edge_twins(F, 4);
  CHECK(twin == (std::vector<int>{-1, 3, -1, 1, -1, -1}));
  CHECK(next_corner(5) == 3 && previous_corner(3) == 5);
  CHECK_THROWS(half_edge_twins({{0, 1, 2}, {1, 2, 3}}, 4), InputError, "edge 1-2: the triangles 0 and 1");
  CHECK_THROWS(half_edge_twins({{0, 1, 2}, {2, 1, 3}, {2, 1, 4}}, 5), InputError, "edge 1-2 has 3 triangles");
  CHECK_THROWS(half_edge_twins({{0, 1, 4}}, 4), InputError, "triangle 0: vertex 4, allowed are 0 to 3");
  CHECK_THROWS(half_edge_twins({{0, 1, 1}}, 4), InputError, "triangle 0 repeats a vertex");
}

// Two tets below and above the triangle 0 1 2.
static const std::vector<Tet> two_tets{{0, 1, 2, 3}, {0, 2, 1, 4}};

static void test_tets() {
  const std::vector<int> twin = half_face_twins(two_tets, 5);
  CHECK(twin[3] == 7 && twin[7] == 3);
  CHECK(std::count(twin.begin(), twin.end(), -1) == 6);
  CHECK(is_coherently_oriented(two_tets, twin, 3));
  const std::vector<Tet> turned{{0, 1, 2, 3}, {0, 1, 2, 4}};
  CHECK(!is_coherently_oriented(turned, half_face_twins(turned, 5), 3));
  CHECK_THROWS(half_face_twins({{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}}, 6), InputError,
               "face 0-1-2 has 3 tets");
  CHECK_THROWS(half_face_twins({{0, 1, 2, 2}}, 4), InputError, "tet 0 repeats vertex 2");
  CHECK_THROWS(half_face_twins({{0, 1, 2, -1}}, 4), InputError, "tet 0: vertex -1");
  CHECK_NEAR(signed_volume6({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}}, 0), 1.0, 0.0);
}

// `spokes` tets around the edge from vertex 0 (below) to 1 (above); the rim is counter-clockwise.
static std::vector<Tet> wheel(int spokes, bool closed) {
  std::vector<Tet> T;
  for (int i = 0; i < (closed ? spokes : spokes - 1); ++i) T.push_back({0, 2 + i, 2 + (i + 1) % spokes, 1});
  return T;
}

static std::size_t find_edge(const EdgeRings& rings, int a, int b) {
  for (std::size_t e = 0; e < rings.vertices.size(); ++e) {
    if (rings.vertices[e] == std::array<int, 2>{a, b}) return e;
  }
  return rings.vertices.size();
}

static void test_closed_ring() {
  const std::vector<Tet> T = wheel(5, true);
  const std::vector<int> twin = half_face_twins(T, 7);
  const EdgeRings rings = edge_rings(T, twin);
  CHECK(rings.vertices.size() == 16);  // axis, 5 rim edges, 10 spokes
  const std::size_t axis = find_edge(rings, 0, 1);
  const auto ring = rings.ring(axis);
  CHECK(rings.on_boundary[axis] == 0 && ring.size() == 5);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    CHECK(twin[static_cast<std::size_t>(ring[i])] / 4 == ring[(i + 1) % 5] / 4);
    CHECK(ring[i] / 4 == static_cast<int>(i));  // counter-clockwise, as the wheel was built
  }
}

static void test_open_ring() {
  const std::vector<Tet> T = wheel(5, false);
  const EdgeRings rings = edge_rings(T, half_face_twins(T, 7));
  const std::size_t axis = find_edge(rings, 0, 1);
  CHECK(rings.on_boundary[axis] == 1 && rings.ring(axis).size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(rings.ring(axis)[i] / 4 == static_cast<int>(i));
  std::set<int> edges_of_first(rings.edge_of_tet[0].begin(), rings.edge_of_tet[0].end());
  CHECK(edges_of_first.size() == 6 && edges_of_first.count(-1) == 0);
}

int main() {
  test_triangles();
  test_tets();
  test_closed_ring();
  test_open_ring();
  return test_result();
}
