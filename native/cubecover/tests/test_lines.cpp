// Singular lines made by hand in the matchings of a box: their orientation, unzipping and removal.
#include <algorithm>
#include <random>

#include "core/testing.hpp"
#include "cubecover/arc_orientation.hpp"
#include "cubecover/arc_removal.hpp"
#include "cubecover/line_repair.hpp"
#include "cubecover/parametrize.hpp"
#include "cubecover/parting_ribbons.hpp"
#include "cubecover/settling.hpp"
#include "grid_meshes.hpp"

namespace neurframe {
namespace {

constexpr int turn_index(int axis) {
  for (int i = 0; i < OctahedralRotation::count; ++i) {
    const OctahedralRotation rotation(i);
    if (rotation.fixed_axis() == axis && rotation.quarter_turn_sign() == 1) return i;
  }
  return -1;
}

constexpr OctahedralRotation turn_about_z(turn_index(2));

constexpr OctahedralRotation turn_about_x(turn_index(0));

// The faces across an axis whose corners are all inside turn so, and so do the edges round them.
template <class Inside>
void turn_sheet(FieldMesh& mesh, int across, OctahedralRotation turn, const Inside& inside) {
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) < 0 || area_vector(mesh, h).normalized()(across) < 0.99) continue;
    const auto corners = half_face_vertices(mesh.tets, h);
    if (std::all_of(corners.begin(), corners.end(), [&](int v) { return inside(at(mesh.points, v)); }))
      set_matching(mesh, h, turn);
  }
}

// The faces in the plane x = 3 inside a rectangle turn about z.
FieldMesh box_with_sheet(double y_least, double y_most, double z_least, double z_most) {
  FieldMesh mesh = box({6, 6, 6});
  turn_sheet(mesh, 0, turn_about_z, [&](const Eigen::Vector3d& p) {
    return p.x() == 3 && p.y() >= y_least && p.y() <= y_most && p.z() >= z_least && p.z() <= z_most;
  });
  return mesh;
}

// A line along z and one along x that meet in the middle of the box.
FieldMesh box_with_node() {
  FieldMesh mesh = box_with_sheet(3, 6, 0, 6);
  turn_sheet(mesh, 2, turn_about_x, [](const Eigen::Vector3d& p) { return p.z() == 3 && p.y() <= 3; });
  return mesh;
}

// The same field, every tet in a chart of its own: the products of matchings do not commute then.
FieldMesh in_other_charts(FieldMesh mesh) {
  std::mt19937 random(1);
  for (int t = 0; t < mesh.tet_count(); ++t) {
    const OctahedralRotation turn(static_cast<int>(random() % OctahedralRotation::count));
    at(mesh.frames, t) = at(mesh.frames, t) * to_matrix(turn.inverse());
    for (int h = 4 * t; h < 4 * t + 4; ++h)
      if (at(mesh.twin, h) >= 0) set_matching(mesh, h, at(mesh.matchings, h) * turn.inverse());
  }
  return mesh;
}

// Three lines of valence 3 along z, two of which come aside to touch the third in the middle of the box; each
// has one of valence 5 beside it, where its sheet ends.
FieldMesh box_with_touching_lines() {
  FieldMesh mesh = box_with_sheet(3, 5, 0, 6);
  const Eigen::Vector3d middle(3, 3, 3);
  turn_sheet(mesh, 1, turn_about_z, [&](const Eigen::Vector3d& p) {
    return p.y() == 3 && ((p.x() >= 4 && p.x() <= 5) || p == middle);
  });
  turn_sheet(mesh, 1, turn_about_z.inverse(), [&](const Eigen::Vector3d& p) {
    return p.y() == 3 && ((p.x() >= 1 && p.x() <= 2) || p == middle);
  });
  return mesh;
}

int count(const std::vector<Defect>& defects, Defect::Kind kind) {
  return static_cast<int>(
      std::count_if(defects.begin(), defects.end(), [&](const Defect& d) { return d.kind == kind; }));
}

// A turn that comes from below and goes back there: up, across, down.
FieldMesh box_with_turn() {
  return box_with_sheet(2, 4, 0, 3);
}

void test_straight_lines() {
  const CombedField field = comb_field(box_with_sheet(2, 4, 0, 6));
  CHECK(field.singular.edges.size() == 12);
  CHECK(field.singular.arcs.size() == 2);
  CHECK(field.singular.arcs[0].valence + field.singular.arcs[1].valence == 8);
  CHECK(count(field_defects(field), Defect::Kind::turning_point) == 0);
  CHECK(count(field_defects(field), Defect::Kind::grazing_end) == 0);
}

void test_turn_is_one_turning_point() {
  const CombedField field = comb_field(box_with_turn());
  CHECK(field.singular.edges.size() == 8);
  CHECK(field.singular.arcs.size() == 1);
  CHECK(count(field_defects(field), Defect::Kind::turning_point) == 1);
}

// A corner cut off the sheet's side makes its line go across, and a little back: it remains one line.
void test_jog_is_no_turning_point() {
  FieldMesh mesh = box_with_sheet(2, 4, 0, 6);
  for (Eigen::Vector3d& point : mesh.points) {
    if (point == Eigen::Vector3d(3, 2, 3)) point.z() = 1.9;  // behind the vertex before it
  }
  const CombedField field = comb_field(mesh);
  CHECK(count(field_defects(field), Defect::Kind::turning_point) == 0);
  for (const SingularArc& arc : field.singular.arcs) {
    for (const int e : arc.edges) CHECK(at(field.singular.edges, e).valence == arc.valence);
  }
}

// With the valences of its four edges set by hand: two lines of valence 3 may cross, and so may two of 5.
void test_impossible_nodes() {
  CombedField field = comb_field(box_with_node());
  CHECK(field.singular.nodes.size() == 1);
  const auto told = [&](const std::vector<int>& valences) {
    const std::vector<int>& around = at(field.singular.edges_of_vertex, field.singular.nodes.front());
    CHECK(around.size() == valences.size());
    for (std::size_t i = 0; i < around.size(); ++i) at(field.singular.edges, around[i]).valence = valences[i];
    return count(field_defects(field), Defect::Kind::impossible_node);
  };
  CHECK(told({3, 3, 3, 3}) == 0);
  CHECK(told({5, 5, 5, 5}) == 0);
  CHECK(told({3, 3, 3, 5}) == 1);
  CHECK(told({3, 3, 3, 6}) == 0);  // other valences are not judged
  CHECK(weight_of(Defect::Kind::impossible_node) == 0);
}

int singular_edges_at(const FieldMesh& mesh, const EdgeRings& rings, int vertex) {
  const SingularGraph graph = find_singular_graph(mesh, rings);
  return static_cast<int>(at(graph.edges_of_vertex, vertex).size());
}

// Six edges of valence 3 meet, which are three lines: each can be taken past the two others.
void test_parting_of_touching_lines() {
  for (const FieldMesh& touching : {box_with_touching_lines(), in_other_charts(box_with_touching_lines())}) {
    const EdgeRings rings = edge_rings(touching.tets, touching.twin);
    const SingularGraph graph = oriented_singular_graph(touching, rings);
    CHECK(graph.nodes.size() == 1);
    CHECK(impossible_nodes(graph) == graph.nodes);
    const std::vector<Ribbon> ribbons = parting_ribbons(touching, rings, graph, graph.nodes);
    CHECK(ribbons.size() >= 3);
    for (const Ribbon& ribbon : ribbons) {
      FieldMesh mesh = touching;
      for (const LineMove& move : ribbon) move_line(mesh, rings, move);
      CHECK(singular_edges_at(mesh, rings, graph.nodes.front()) == 4);
    }
  }
}

// A line along z and one along x: only edges that are opposite go on in each other.
void test_parting_of_crossing_lines() {
  for (const FieldMesh& crossing : {box_with_node(), in_other_charts(box_with_node())}) {
    const EdgeRings rings = edge_rings(crossing.tets, crossing.twin);
    const SingularGraph graph = oriented_singular_graph(crossing, rings);
    CHECK(at(graph.edges_of_vertex, graph.nodes.front()).size() == 4);
    const std::vector<Ribbon> ribbons = parting_ribbons(crossing, rings, graph, graph.nodes);
    CHECK(!ribbons.empty());
    for (const Ribbon& ribbon : ribbons) {
      FieldMesh mesh = crossing;
      for (const LineMove& move : ribbon) move_line(mesh, rings, move);
      CHECK(singular_edges_at(mesh, rings, graph.nodes.front()) == 2);
      for (const LineMove& move : ribbon)
        for (const int v : half_face_vertices(mesh.tets, move.half_face))
          CHECK(v == graph.nodes.front() || !at(boundary_vertices(mesh), v));
    }
  }
}

std::size_t folded_tets(const PreparedField& prepared) {
  const ParametrizeOptions options{1, 0, 1, Polycubes::never, 1};
  return solve_prepared(prepared, options, [](double, std::string_view) {}).verification.folded_tets.size();
}

// With one line taken away two remain, which four edges of valence 3 do not tell from a node; the map does.
void test_repair_of_nodes() {
  PreparedField prepared = judged_field(box_with_touching_lines(), {});
  CHECK(prepared.score() == 0);
  CHECK(folded_tets(prepared) > 0);
  prepared = with_line_repairs(std::move(prepared));
  CHECK(prepared.preparation.line_moves == 1);
  CHECK(prepared.field.singular.nodes.size() == 1);
  CHECK(impossible_nodes(prepared.field.singular).empty());
  CHECK(folded_tets(prepared) > 0);
  prepared = with_lines_parted(prepared.field.mesh, prepared.preparation);
  CHECK(prepared.score() == 0);
  CHECK(prepared.field.singular.nodes.empty());
  CHECK(folded_tets(prepared) == 0);
}

// The line arrives at a side of the box across its axis, which lies in that side.
void test_grazing_end() {
  const CombedField field = comb_field(box_with_sheet(0, 2, 0, 3));
  CHECK(count(field_defects(field), Defect::Kind::grazing_end) == 1);
}

// A box with two features on its top that leave a vertex along x, towards points that are so far along y.
FieldMesh box_with_corner(double y_of_one, double y_of_other) {
  FieldMesh mesh = box({6, 6, 6});
  std::vector<int> ends;
  for (const Eigen::Vector3d& wanted :
       {Eigen::Vector3d(3, 3, 6), Eigen::Vector3d(4, 3, 6), Eigen::Vector3d(4, 4, 6)}) {
    const auto found = std::find(mesh.points.begin(), mesh.points.end(), wanted);
    ends.push_back(static_cast<int>(found - mesh.points.begin()));
  }
  at(mesh.points, ends[1]).y() = y_of_one;
  at(mesh.points, ends[2]).y() = y_of_other;
  mesh.features.push_back(edge_key(ends[0], ends[1]));
  mesh.features.push_back(edge_key(ends[0], ends[2]));
  std::sort(mesh.features.begin(), mesh.features.end());
  return mesh;
}

// Features at an angle of 22 degrees are both along x, whatever the frames; at one of 70 with these.
void test_cusp_and_empty_corner() {
  const auto told = [](const FieldMesh& mesh) {
    const std::vector<Defect> defects = field_defects(comb_field(mesh));
    return std::pair(count(defects, Defect::Kind::cusp), count(defects, Defect::Kind::empty_corner));
  };
  CHECK(told(box({6, 6, 6})) == std::pair(0, 0));
  CHECK(told(box_with_corner(3, 3.4)) == std::pair(1, 0));
  CHECK(told(box_with_corner(2.3, 3.7)) == std::pair(0, 1));
}

void test_removal() {
  FieldMesh mesh = box_with_turn();
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  const SingularGraph graph = find_singular_graph(mesh, rings);
  CHECK(!remove_arc(mesh, rings, graph, graph.arcs.front()).empty());
  CHECK(find_singular_graph(mesh, rings).edges.empty());
}

// A line from the bottom to the top spans no surface on which its axis is normal to the boundary.
void test_no_removal_of_straight_lines() {
  FieldMesh mesh = box_with_sheet(2, 4, 0, 6);
  const EdgeRings rings = edge_rings(mesh.tets, mesh.twin);
  const SingularGraph graph = find_singular_graph(mesh, rings);
  for (const SingularArc& arc : graph.arcs) CHECK(remove_arc(mesh, rings, graph, arc).empty());
  CHECK(find_singular_graph(mesh, rings).edges.size() == 12);
}

void test_ribbons() {
  const FieldMesh turned = box_with_turn();
  const EdgeRings rings = edge_rings(turned.tets, turned.twin);
  const std::vector<Ribbon> ribbons = unzipping_ribbons(turned, rings);
  CHECK(!ribbons.empty());
  for (const Ribbon& ribbon : ribbons) {
    FieldMesh mesh = turned;
    std::vector<int> faces;
    for (const LineMove& move : ribbon) {
      move_line(mesh, rings, move);
      faces.push_back(move.half_face);
    }
    settle_frames(mesh, boundary_alignments(mesh), faces);
    const CombedField field = comb_field(mesh);
    CHECK(field.singular.arcs.size() == 2);
    CHECK(field.singular.nodes.empty());
    for (const SingularArc& arc : field.singular.arcs)
      CHECK(at(mesh.points, arc.vertices.front()).z() + at(mesh.points, arc.vertices.back()).z() == 6);
    CHECK(count(field_defects(field), Defect::Kind::turning_point) == 0);
  }
}

// Made sound by itself, with what keeps the field nearer to what it was.
void test_repair() {
  PreparedField prepared = judged_field(box_with_turn(), {});
  CHECK(prepared.score() > 0);
  prepared = with_line_repairs(std::move(prepared));
  CHECK(prepared.score() == 0);
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_straight_lines();
  neurframe::test_turn_is_one_turning_point();
  neurframe::test_jog_is_no_turning_point();
  neurframe::test_impossible_nodes();
  neurframe::test_parting_of_touching_lines();
  neurframe::test_parting_of_crossing_lines();
  neurframe::test_repair_of_nodes();
  neurframe::test_grazing_end();
  neurframe::test_cusp_and_empty_corner();
  neurframe::test_removal();
  neurframe::test_no_removal_of_straight_lines();
  neurframe::test_ribbons();
  neurframe::test_repair();
  return neurframe::test_result();
}
