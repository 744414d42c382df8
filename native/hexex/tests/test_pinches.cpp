// Hexes that touch in vertices and edges only: random subsets of a grid, and the smallest cases by hand.
#include <map>
#include <random>
#include <set>

#include "core/extraction/separate_pinches.hpp"
#include "core/hex_io.hpp"
#include "core/testing.hpp"

using namespace neurframe;

using Place = std::array<int, 3>;

static constexpr int side = 5;  // vertices of the grid along an axis
static constexpr int grid_vertices = side * side * side;

struct Separated {
  std::vector<CellVertices<3>> hexes;
  std::vector<LostCell<3>> lost;
  std::vector<int> copied;
};

static Separated separated(const std::vector<Place>& places) {
  TracedCells<3> traced;
  AssembledCells<3> assembled;
  for (const Place& p : places) {
    CellVertices<3> hex{};
    for (std::size_t i = 0; i < 8; ++i) {
      const int corner = CellShape<3>::corners[i];
      const int x = p[0] + (corner & 1);
      const int y = p[1] + (corner >> 1 & 1);
      const int z = p[2] + (corner >> 2 & 1);
      hex[i] = (x * side + y) * side + z;
    }
    assembled.traced.push_back(static_cast<int>(traced.cells.size()));
    assembled.cells.push_back(hex);
    traced.cells.push_back({static_cast<int>(traced.cells.size()), {}, {}, 1, {}});
  }
  const std::vector<int> copied = separate_pinches(traced, grid_vertices, assembled);
  return {assembled.cells, assembled.lost, copied};
}

// Whether links between the members, two at a time, make all of them one.
static bool all_linked(const std::set<int>& members, const std::vector<std::array<int, 2>>& links) {
  std::set<int> reached;
  if (!members.empty()) reached.insert(*members.begin());
  for (std::size_t before = 0; before != reached.size();) {
    before = reached.size();
    for (const auto& [a, b] : links) {
      if (reached.count(a) + reached.count(b) == 1) reached.insert({a, b});
    }
  }
  return reached.size() == members.size();
}

struct Face {
  std::array<int, 4> vertices;
  std::vector<int> hexes;
};

static std::vector<Face> faces_of(const std::vector<CellVertices<3>>& hexes) {
  std::map<std::array<int, 4>, Face> faces;
  for (std::size_t h = 0; h < hexes.size(); ++h) {
    for (std::size_t f = 0; f < 6; ++f) {
      const std::array<int, 4> vertices = cell_facet<3>(hexes[h], f);
      std::array<int, 4> key = vertices;
      std::sort(key.begin(), key.end());
      Face& face = faces[key];
      face.vertices = vertices;
      face.hexes.push_back(static_cast<int>(h));
    }
  }
  std::vector<Face> found;
  for (const auto& [key, face] : faces) found.push_back(face);
  return found;
}

// Round every vertex the hexes hang together by faces, and the quads of the shell by edges; no edge of the
// shell is in more than two of its quads.
static bool is_manifold(const std::vector<CellVertices<3>>& hexes) {
  std::map<int, std::set<int>> hexes_at;
  std::map<int, std::set<int>> quads_at;
  std::map<int, std::vector<std::array<int, 2>>> hex_links;
  std::map<std::array<int, 2>, std::vector<int>> quads_of_edge;
  for (std::size_t h = 0; h < hexes.size(); ++h) {
    for (const int v : hexes[h]) hexes_at[v].insert(static_cast<int>(h));
  }
  const std::vector<Face> faces = faces_of(hexes);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Face& face = faces[f];
    for (std::size_t i = 0; i < 4; ++i) {
      const int v = face.vertices[i];
      if (face.hexes.size() == 2) hex_links[v].push_back({face.hexes[0], face.hexes[1]});
      if (face.hexes.size() == 2) continue;
      quads_at[v].insert(static_cast<int>(f));
      const int w = face.vertices[(i + 1) % 4];
      quads_of_edge[{std::min(v, w), std::max(v, w)}].push_back(static_cast<int>(f));
    }
  }
  std::map<int, std::vector<std::array<int, 2>>> quad_links;
  for (const auto& [edge, quads] : quads_of_edge) {
    if (quads.size() != 2) return false;
    for (const int v : edge) quad_links[v].push_back({quads[0], quads[1]});
  }
  return std::all_of(hexes_at.begin(), hexes_at.end(), [&](const auto& at) {
    return all_linked(at.second, hex_links[at.first]) && all_linked(quads_at[at.first], quad_links[at.first]);
  });
}

static void test_known_cases() {
  const Separated vertex = separated({{0, 0, 0}, {1, 1, 1}});
  CHECK(vertex.hexes.size() == 2 && vertex.lost.empty());
  CHECK(vertex.copied == std::vector<int>{(side + 1) * side + 1});
  const Separated edge = separated({{0, 0, 0}, {1, 1, 0}});
  CHECK(edge.hexes.size() == 2 && edge.copied.size() == 2);
  const Separated whole = separated({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  CHECK(whole.hexes.size() == 4 && whole.copied.empty() && whole.lost.empty());
}

// Two opposite octants of eight are missing: the other six make a ring round the vertex.  Without one of them
// the ends of the ring still meet in an edge, without two they do not.
static void test_ring_of_hexes() {
  std::vector<Place> six;
  for (int i = 1; i < 7; ++i) six.push_back({i & 1, i >> 1 & 1, i >> 2});
  const Separated ring = separated(six);
  CHECK(is_manifold(ring.hexes));
  CHECK(ring.hexes.size() == 4 && ring.copied.empty());
  CHECK(ring.lost.size() == 2 && ring.lost.front().loss == CellLoss::pinched);
}

// A closed ring of hexes whose two ends meet in an edge: its vertices cannot be taken apart, the hexes hang
// together.
static void test_edge_between_connected_hexes() {
  std::vector<Place> places;
  for (int z = 0; z < 3; ++z) {
    for (int i = 0; i < 4; ++i) {
      const bool missing = z == 1 && (i == 0 || i == 3);
      if (!missing) places.push_back({i & 1, i >> 1, z});
    }
  }
  const Separated found = separated(places);
  CHECK(is_manifold(found.hexes));
  CHECK(found.hexes.size() + found.lost.size() == places.size());
  CHECK(found.lost.size() == 1);
}

static void test_random_subsets() {
  std::mt19937 random(7);
  std::size_t copies = 0;
  std::size_t lost = 0;
  for (int round = 0; round < 200; ++round) {
    const unsigned kept = 2 + static_cast<unsigned>(round) % 7;  // of ten
    std::vector<Place> places;
    for (int i = 0; i < 64; ++i) {
      if (random() % 10 < kept) places.push_back({i / 16, i / 4 % 4, i % 4});
    }
    const Separated found = separated(places);
    CHECK(is_manifold(found.hexes));
    CHECK(found.hexes.size() + found.lost.size() == places.size());
    copies += found.copied.size();
    lost += found.lost.size();
  }
  CHECK(copies > 100);
  CHECK(lost > 10);
  CHECK(lost < 1500);
}

int main() {
  test_known_cases();
  test_ring_of_hexes();
  test_edge_between_connected_hexes();
  test_random_subsets();
  return test_result();
}
