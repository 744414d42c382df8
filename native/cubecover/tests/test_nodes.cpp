// The types of interior nodes, found again among all triangulations of the sphere with few corners.
#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/testing.hpp"
#include "cubecover/node_types.hpp"

namespace neurframe {
namespace {

// Per corner its neighbours, counter-clockwise.
using Triangulation = std::vector<std::vector<int>>;

const std::vector<int>& around(const Triangulation& triangulation, int corner) {
  return triangulation[static_cast<std::size_t>(corner)];
}

// The neighbour `step` places after the one that is given.
int neighbour(const std::vector<int>& ring, int from, int step) {
  const auto place = std::find(ring.begin(), ring.end(), from) - ring.begin();
  const auto size = static_cast<std::ptrdiff_t>(ring.size());
  return ring[static_cast<std::size_t>((place + step + size) % size)];
}

void insert_after(std::vector<int>& ring, int before, int corner) {
  ring.insert(std::find(ring.begin(), ring.end(), before) + 1, corner);
}

bool is_adjacent(const Triangulation& triangulation, int one, int other) {
  const std::vector<int>& ring = around(triangulation, one);
  return std::find(ring.begin(), ring.end(), other) != ring.end();
}

// Corners numbered in the order of a walk that starts along one edge, and their neighbours by these numbers.
std::string code_from(const Triangulation& triangulation, int first, int second, int step) {
  std::vector<int> number(triangulation.size(), -1), order = {first, second}, entry = {second, first};
  number[static_cast<std::size_t>(first)] = 0;
  number[static_cast<std::size_t>(second)] = 1;
  std::string code;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::vector<int>& ring = around(triangulation, order[i]);
    int corner = entry[i];
    for (std::size_t k = 0; k < ring.size(); ++k, corner = neighbour(ring, corner, step)) {
      int& named = number[static_cast<std::size_t>(corner)];
      if (named < 0) {
        named = static_cast<int>(order.size());
        order.push_back(corner);
        entry.push_back(order[i]);
      }
      code.push_back(static_cast<char>('a' + named));
    }
    code.push_back('|');
  }
  return code;
}

// The same for triangulations that differ in the numbers of their corners or are mirrored: the least code
// from an edge whose ends have the highest degrees.
std::string code_of(const Triangulation& triangulation) {
  std::pair<std::size_t, std::size_t> highest = {0, 0};
  std::string least;
  for (int one = 0; one < static_cast<int>(triangulation.size()); ++one) {
    for (const int other : around(triangulation, one)) {
      const std::pair degrees = {around(triangulation, one).size(), around(triangulation, other).size()};
      if (degrees < highest) continue;
      for (const int step : {1, -1}) {
        std::string code = code_from(triangulation, one, other, step);
        if (degrees > highest || code < least) least = std::move(code);
        highest = degrees;
      }
    }
  }
  return least;
}

// The other diagonal of the two triangles at an edge; the triangulation stays simple.
bool flip(Triangulation& triangulation, int one, int other) {
  const int left = neighbour(around(triangulation, one), other, 1);
  const int right = neighbour(around(triangulation, one), other, -1);
  if (is_adjacent(triangulation, left, right)) return false;
  std::erase(triangulation[static_cast<std::size_t>(one)], other);
  std::erase(triangulation[static_cast<std::size_t>(other)], one);
  insert_after(triangulation[static_cast<std::size_t>(left)], one, right);
  insert_after(triangulation[static_cast<std::size_t>(right)], other, left);
  return true;
}

// A corner in a triangle of the tetrahedron, another one in a triangle beside it, and so on.
Triangulation any_triangulation(int corners) {
  Triangulation made = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (int added = 4; added < corners; ++added) {
    const int one = added - 1;
    const int second = around(made, one)[0];
    const int third = neighbour(around(made, one), second, 1);
    insert_after(made[static_cast<std::size_t>(one)], second, added);
    insert_after(made[static_cast<std::size_t>(second)], third, added);
    insert_after(made[static_cast<std::size_t>(third)], one, added);
    made.push_back({one, second, third});
  }
  return made;
}

// Flips lead from each simple triangulation to every other one with as many corners (Wagner 1936).
std::vector<Triangulation> all_triangulations(int corners) {
  std::vector<Triangulation> found = {any_triangulation(corners)};
  std::set<std::string> seen = {code_of(found.front())};
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (int one = 0; one < corners; ++one) {
      const std::vector<int> ring = around(found[i], one);
      for (const int other : ring) {
        Triangulation flipped = found[i];
        if (one < other && flip(flipped, one, other) && seen.insert(code_of(flipped)).second)
          found.push_back(std::move(flipped));
      }
    }
  }
  return found;
}

bool has_low_degrees(const Triangulation& triangulation) {
  return std::all_of(triangulation.begin(), triangulation.end(),
                     [](const std::vector<int>& ring) { return ring.size() >= 3 && ring.size() <= 5; });
}

int corners_of_degree(const Triangulation& triangulation, std::size_t degree) {
  return static_cast<int>(std::count_if(triangulation.begin(), triangulation.end(),
                                        [&](const std::vector<int>& ring) { return ring.size() == degree; }));
}

void test_table_is_complete() {
  const std::vector<std::size_t> numbers = {1, 1, 2, 5, 14, 50, 233, 1249};  // of 4 to 11 corners
  std::set<NodeType> found = {{0, 12}};  // 12 corners leave degree 5 only: the icosahedron
  for (int corners = 4; corners <= 11; ++corners) {
    const std::vector<Triangulation> all = all_triangulations(corners);
    CHECK(all.size() == numbers[static_cast<std::size_t>(corners - 4)]);
    for (const Triangulation& one : all) {
      if (has_low_degrees(one)) found.insert({corners_of_degree(one, 3), corners_of_degree(one, 5)});
    }
  }
  CHECK(found == std::set<NodeType>(node_types.begin(), node_types.end()));
  CHECK(found.size() == node_types.size());
}

void test_single_types() {
  CHECK(is_node_type({0, 0}));    // a regular vertex: the octahedron
  CHECK(is_node_type({4, 0}));    // the tetrahedron
  CHECK(is_node_type({0, 12}));   // the icosahedron
  CHECK(!is_node_type({3, 1}));   // five corners: only the bipyramid has so few
  CHECK(!is_node_type({0, 10}));  // eleven corners
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_table_is_complete();
  neurframe::test_single_types();
  return neurframe::test_result();
}
