// Labels, borders and maps of polycubes: against closed forms and against trying everything.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/testing.hpp"
#include "cubecover/face_targets.hpp"
#include "cubecover/label_corners.hpp"
#include "cubecover/max_flow.hpp"
#include "cubecover/parametrize.hpp"
#include "cubecover/poisson.hpp"
#include "cubecover/rotation_field.hpp"
#include "cubecover/separation.hpp"
#include "cubecover/surface_labels.hpp"
#include "cubecover/turning_borders.hpp"
#include "grid_meshes.hpp"

namespace neurframe {
namespace {

struct CutProblem {
  int nodes;
  std::vector<std::array<double, 2>> node_cost;  // on the source's side, on the sink's
  std::vector<std::vector<double>> capacity;     // from, to
};

CutProblem random_problem(std::mt19937_64& random) {
  std::uniform_int_distribution<int> any(0, 5);
  CutProblem problem{4, {}, std::vector<std::vector<double>>(4, std::vector<double>(4))};
  for (int i = 0; i < problem.nodes; ++i)
    problem.node_cost.push_back({static_cast<double>(any(random)), static_cast<double>(any(random))});
  for (std::vector<double>& row : problem.capacity) {
    for (double& capacity : row) capacity = any(random);
  }
  return problem;
}

double cost_of(const CutProblem& problem, const std::vector<char>& sink_side) {
  double cost = 0;
  for (int i = 0; i < problem.nodes; ++i) {
    cost += at(at(problem.node_cost, i), at(sink_side, i));
    for (int j = 0; j < problem.nodes; ++j) {
      if (i != j && !at(sink_side, i) && at(sink_side, j)) cost += at(at(problem.capacity, i), j);
    }
  }
  return cost;
}

void test_minimum_cut() {
  std::mt19937_64 random(1);
  for (int round = 0; round < 200; ++round) {
    const CutProblem problem = random_problem(random);
    MinimumCut cut(problem.nodes);
    for (int i = 0; i < problem.nodes; ++i) {
      cut.add_node_cost(i, at(problem.node_cost, i)[0], at(problem.node_cost, i)[1]);
      for (int j = 0; j < problem.nodes; ++j) {
        if (i != j) cut.add_edge(i, j, at(at(problem.capacity, i), j));
      }
    }
    double least = 1e300;
    for (int bits = 0; bits < 1 << problem.nodes; ++bits) {
      std::vector<char> sides;
      for (int i = 0; i < problem.nodes; ++i) sides.push_back(static_cast<char>(bits >> i & 1));
      least = std::min(least, cost_of(problem, sides));
    }
    CHECK_NEAR(cost_of(problem, cut.sink_side()), least, 1e-9);
  }
}

SignedAxis axis_nearest(const Eigen::Vector3d& direction) {
  SignedAxis axis;
  direction.cwiseAbs().maxCoeff(&axis.axis);
  axis.sign = direction(axis.axis) < 0 ? -1 : 1;
  return axis;
}

std::vector<BoundaryEdge> boundary_edges_of(const FieldMesh& mesh) {
  return find_boundary_edges(mesh, edge_rings(mesh.tets, mesh.twin));
}

std::vector<SignedAxis> labels_by_normal(const FieldMesh& mesh) {
  std::vector<SignedAxis> labels(mesh.twin.size());
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) < 0) at(labels, h) = axis_nearest(area_vector(mesh, h));
  }
  return labels;
}

void test_labels_of_an_l_shape_are_its_normals() {
  const FieldMesh mesh = l_shape(4, 2);
  const std::vector<SignedAxis> labels = surface_labels(mesh, boundary_edges_of(mesh), {1, 0});
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    if (at(mesh.twin, h) < 0) CHECK(at(labels, h) == axis_nearest(area_vector(mesh, h)));
  }
}

// With the face z = 2 labelled as y, the border of the notch's wall runs up the concave edge and on along a
// convex one.
void test_turning_border_is_found() {
  const FieldMesh mesh = l_shape(4, 2);
  const std::vector<BoundaryEdge> edges = boundary_edges_of(mesh);
  std::vector<SignedAxis> labels = labels_by_normal(mesh);
  CHECK(find_turning_borders(mesh, edges, labels).empty());
  for (SignedAxis& label : labels) {
    if (label == SignedAxis{2, 1}) label = {1, 1};
  }
  const std::vector<TurningBorder> found = find_turning_borders(mesh, edges, labels);
  CHECK(found.size() == 1);
  if (found.empty()) return;
  CHECK(found[0].axes[0] + found[0].axes[1] == 1);
  CHECK(found[0].parts[0].size() == 4);  // convex: two edges along the top, two down the far side
  CHECK(found[0].parts[2].size() == 2);  // concave: two edges up the notch
}

long impossible_count(const std::vector<LabelCorner>& corners) {
  return std::count_if(corners.begin(), corners.end(),
                       [](const LabelCorner& corner) { return !corner.is_possible; });
}

// Top and bottom of an L have one angle of three quarter turns each, all others are right.  Seen in a mirror,
// the labels turn the wrong way round every corner.
void test_corners_of_an_l_shape() {
  const FieldMesh mesh = l_shape(4, 2);
  const std::vector<BoundaryEdge> edges = boundary_edges_of(mesh);
  std::vector<SignedAxis> labels = labels_by_normal(mesh);
  const std::vector<LabelCorner> corners = find_label_corners(mesh, edges, labels);
  CHECK(corners.size() == 12);
  CHECK(impossible_count(corners) == 0);
  int right = 0, reflex = 0;
  for (const LabelCorner& corner : corners) {
    CHECK_NEAR(corner.stretch, 0, 1e-9);
    for (const LabelCorner::Fan& fan : corner.fans) {
      CHECK(fan.least_quarter_turns == fan.most_quarter_turns);
      right += fan.least_quarter_turns == 1 ? 1 : 0;
      reflex += fan.least_quarter_turns == 3 ? 1 : 0;
    }
  }
  CHECK(right == 34 && reflex == 2);
  for (SignedAxis& label : labels) label.sign = label.axis == 2 ? -label.sign : label.sign;
  CHECK(impossible_count(find_label_corners(mesh, edges, labels)) == 12);
}

// A slab with a prism on one half of it, whose side stands on the diagonal.
FieldMesh slab_with_prism(int width) {
  GridMesh grid = grid_mesh({width, width, 3}, keep_all);
  std::erase_if(grid.tets, [&](const Tet& tet) {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const int v : tet) center += at(grid.points, v) / 4;
    return center.z() > 1 && center.x() < center.y();
  });
  std::vector<int> number(grid.points.size(), -1);
  std::vector<Eigen::Vector3d> points;
  for (Tet& tet : grid.tets) {
    for (int& v : tet) {
      if (at(number, v) < 0)
        at(number, v) = static_cast<int>(points.size()), points.push_back(at(grid.points, v));
      v = at(number, v);
    }
  }
  return field_mesh({points, grid.tets}, unwarped, constant_frame);
}

// Where the prism's side is labelled as the side of the slab, the two meet in a vertex, with no room for the
// top of the slab between them.
void test_patches_that_meet_in_a_vertex() {
  const FieldMesh mesh = slab_with_prism(6);
  const std::vector<BoundaryEdge> edges = boundary_edges_of(mesh);
  std::vector<SignedAxis> labels = labels_by_normal(mesh);
  for (int h = 0; h < mesh.half_face_count(); ++h) {
    const bool slanted =
        at(mesh.twin, h) < 0 && std::abs(area_vector(mesh, h).normalized().x() + std::sqrt(0.5)) < 1e-6;
    if (slanted) at(labels, h) = {0, -1};
  }
  const auto is_pinch = [&](const LabelCorner& corner) {
    return !corner.is_possible && at(mesh.points, corner.vertex) == Eigen::Vector3d(0, 0, 1);
  };
  const std::vector<LabelCorner> corners = find_label_corners(mesh, edges, labels);
  CHECK(std::count_if(corners.begin(), corners.end(), is_pinch) == 1);
  CHECK(impossible_count(find_label_corners(mesh, edges, surface_labels(mesh, edges, {1, 0}))) == 0);
}

// A corner of 45 degrees, which a polycube opens to 90.
void test_stretch_of_a_prism() {
  const FieldMesh mesh = slab_with_prism(6);
  const std::vector<BoundaryEdge> edges = boundary_edges_of(mesh);
  const std::vector<LabelCorner> corners =
      find_label_corners(mesh, edges, surface_labels(mesh, edges, {1, 0}));
  const auto tip = std::find_if(corners.begin(), corners.end(), [&](const LabelCorner& corner) {
    return at(mesh.points, corner.vertex) == Eigen::Vector3d(0, 0, 3);
  });
  CHECK(tip != corners.end());
  if (tip != corners.end()) CHECK_NEAR(tip->stretch, std::numbers::pi / 4, 1e-9);
}

// With one coordinate mirrored, the faces that it runs along are seen from inside.
void test_turned_faces() {
  const PreparedField prepared = prepare(box({3, 2, 2}), Preparation{});
  const ReducedMap& map = prepared.map;
  const TetTargets targets = make_targets(prepared.field.mesh, 0.5);
  const std::vector<FaceTarget> faces = make_face_targets(prepared.field, targets);
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(map.column_count());
  Eigen::VectorXd rows =
      evaluate(map, minimise(quadratic_energy(targets, map, {}), nothing, map.column_count()));
  CHECK(measure_turned_faces(faces, map, rows).count == 0);
  CHECK_NEAR(measure_turned_faces(faces, map, rows).smallest, 1, 1e-6);
  int along = 0;
  for (const SignedAxis& outward : prepared.field.boundary_axis) along += outward.axis > 0 ? 1 : 0;
  for (Eigen::Index row = 0; row < rows.size(); row += 3) rows(row) = -rows(row);
  CHECK(measure_turned_faces(faces, map, rows).count == along);
}

void test_rotations_meet_their_targets() {
  const FieldMesh mesh = box({4, 2, 2});
  const Eigen::Matrix3d straight = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  std::vector<AxisTarget> targets;
  for (int t = 0; t < mesh.tet_count(); ++t) {
    const double x = tet_center(mesh, t).x();
    if (x > 0.5 && x < 3.5) continue;
    for (int axis = 0; axis < 2; ++axis)
      targets.push_back({t, {axis, 1}, x < 1 ? straight.col(axis) : turned.col(axis)});
  }
  const std::vector<Eigen::Matrix3d> frames = rotation_field(mesh, targets, straight);
  for (int t = 0; t < mesh.tet_count(); ++t) {
    const double angle = Eigen::AngleAxisd(at(frames, t)).angle();
    CHECK_NEAR(at(frames, t).determinant(), 1, 1e-9);
    CHECK(angle > -0.02 && angle < 0.52);
    if (tet_center(mesh, t).x() < 0.5) CHECK_NEAR(angle, 0, 0.02);
    if (tet_center(mesh, t).x() > 3.5) CHECK_NEAR(angle, 0.5, 0.02);
  }
}

Parametrization polycube_map_of(const FieldMesh& mesh, double cell_length) {
  return parametrize(mesh, {cell_length, 0, 1, Polycubes::only}, [](double, const std::string&) {});
}

void test_polycube_maps() {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.83, Eigen::Vector3d(1, -2, 0.7).normalized()).toRotationMatrix();
  std::mt19937_64 random(7);
  const Parametrization of_box =
      polycube_map_of(relabelled(moved(box({3, 2, 4}), rotation, {100, -20, 3}), random), 0.5);
  CHECK(of_box.verification.valid());
  CHECK_NEAR(of_box.parametric_volume, 6 * 4 * 8, 1e-6);
  CHECK_NEAR(of_box.distortion, 5, 1e-4);  // frames and steps are solved loosely
  const Parametrization of_l_shape = polycube_map_of(moved(l_shape(4, 2), rotation, {0, 0, 0}), 0.5);
  CHECK(of_l_shape.verification.valid());
  CHECK_NEAR(of_l_shape.parametric_volume, (8 * 8 - 4 * 4) * 4, 1e-6);
}

// Its round side is divided into four labels; no singular line is left inside.
void test_cylinder_without_singular_lines() {
  const Parametrization result = polycube_map_of(cylinder(8, 4, 0.6), 0.2);
  CHECK(result.verification.valid());
  CHECK(result.field.singular.edges.empty());
  CHECK(result.preparation.is_polycube());
  CHECK_NEAR(result.parametric_volume, std::round(result.parametric_volume), 1e-6);
}

// Every valid map that is counted can be had, each unlike the best one, and no more than these.
void test_alternatives() {
  ParametrizeOptions options{0.5, 0, 1, Polycubes::only};
  const auto map_of = [&](int alternative) {
    options.alternative = alternative;
    return parametrize(slab_with_prism(6), options, [](double, const std::string&) {});
  };
  const Parametrization best = map_of(1);
  CHECK(best.valid_maps >= 2);
  for (int i = 2; i <= best.valid_maps; ++i) {
    const Parametrization other = map_of(i);
    CHECK(other.verification.valid());
    CHECK(other.valid_maps == best.valid_maps);
    CHECK(std::abs(other.distortion / best.distortion - 1) > 0.02);
  }
  CHECK_THROWS(map_of(best.valid_maps + 1), InputError, "valid maps, no number");
}

int vertex_at(const FieldMesh& mesh, const Eigen::Vector3d& point) {
  const auto found = std::find(mesh.points.begin(), mesh.points.end(), point);
  CHECK(found != mesh.points.end());
  return static_cast<int>(found - mesh.points.begin());
}

void add_feature(FieldMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  mesh.features.push_back(edge_key(vertex_at(mesh, from), vertex_at(mesh, to)));
  std::sort(mesh.features.begin(), mesh.features.end());
}

// The tets that touch a point.
std::vector<int> tets_at(const FieldMesh& mesh, const Eigen::Vector3d& point) {
  const int vertex = vertex_at(mesh, point);
  std::vector<int> tets;
  for (int t = 0; t < mesh.tet_count(); ++t) {
    if (std::count(at(mesh.tets, t).begin(), at(mesh.tets, t).end(), vertex)) tets.push_back(t);
  }
  return tets;
}

// Two lines cross on the top of a box: what reaches a tet goes as far as the crossing, the edges of the box
// stay.
void test_inner_features_are_released_up_to_others() {
  FieldMesh mesh = box({4, 2, 2});
  const std::size_t outline = mesh.features.size();
  for (double x = 0; x < 4; ++x) add_feature(mesh, {x, 1, 2}, {x + 1, 1, 2});
  for (double y = 0; y < 2; ++y) add_feature(mesh, {2, y, 2}, {2, y + 1, 2});
  const FieldMesh polycube = polycube_field(mesh, {1, 0});
  CHECK(polycube.features.size() == outline + 6);
  CHECK(without_inner_features(polycube).features.size() == outline);
  const FieldMesh released = without_inner_features_at(polycube, tets_at(polycube, {0, 1, 2}));
  CHECK(released.features.size() == outline + 4);
  CHECK(without_inner_features_at(polycube, tets_at(polycube, {0, 0, 0})).features == polycube.features);
}

// With all integers 0 a box has no volume: every row parts two of its sides, and the true integers keep them
// all.
void test_collapsed_tets_are_kept_apart() {
  PreparedField prepared = prepare(box({3, 1, 2}), Preparation{});
  const ReducedMap& map = prepared.map;
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(map.column_count());
  const TetTargets targets = make_targets(prepared.field.mesh, 0.5);
  const Eigen::VectorXd seamless = minimise(quadratic_energy(targets, map, {}), nothing, map.column_count());
  std::vector<int> tets;
  for (int t = 0; t < prepared.field.mesh.tet_count(); ++t) tets.push_back(t);
  const auto rows_for = [&](const Eigen::VectorXd& columns) {
    return collapsed_rows(prepared.field, prepared.elimination, map, evaluate(map, seamless),
                          evaluate(map, columns), tets);
  };
  const std::vector<SeparationRow> rows = rows_for(nothing);
  CHECK(rows.size() == 1);
  double distance = 0;
  for (int i = 0; i < map.integer_count && !rows.empty(); ++i)
    distance += at(rows[0], i) * seamless(map.real_count + i);
  CHECK_NEAR(distance, 2, 1e-6);
  CHECK(rows_for(seamless).empty());
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_minimum_cut();
  neurframe::test_labels_of_an_l_shape_are_its_normals();
  neurframe::test_turning_border_is_found();
  neurframe::test_corners_of_an_l_shape();
  neurframe::test_patches_that_meet_in_a_vertex();
  neurframe::test_stretch_of_a_prism();
  neurframe::test_turned_faces();
  neurframe::test_rotations_meet_their_targets();
  neurframe::test_polycube_maps();
  neurframe::test_cylinder_without_singular_lines();
  neurframe::test_alternatives();
  neurframe::test_inner_features_are_released_up_to_others();
  neurframe::test_collapsed_tets_are_kept_apart();
  return neurframe::test_result();
}
