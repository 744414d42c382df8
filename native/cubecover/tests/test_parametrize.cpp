// Whole maps of closed-form fields: exact volumes, invariance, singular lines.
#include <cmath>

#include "core/testing.hpp"
#include "cubecover/parametrize.hpp"
#include "grid_meshes.hpp"

namespace neurframe {
namespace {

Parametrization map_of(const FieldMesh& mesh, double cell_length) {
  return parametrize(mesh, {cell_length, 0, 1}, [](double, const std::string&) {});
}

void check_valid_with_volume(const Parametrization& result, double hexes) {
  CHECK(result.verification.valid());
  CHECK(result.defects.empty());
  CHECK_NEAR(result.parametric_volume, hexes, 1e-6);
}

void test_box() {
  const FieldMesh mesh = box({3, 2, 4});
  check_valid_with_volume(map_of(mesh, 0.5), 6 * 4 * 8);
  // 3, 2 and 4 divided by 0.7 are 4.29, 2.86 and 5.71
  check_valid_with_volume(map_of(mesh, 0.7), 4 * 3 * 6);
  // cells larger than the box: one remains, not none
  check_valid_with_volume(map_of(mesh, 20), 1);
}

void test_rigid_motion_and_names_of_axes() {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(0.83, Eigen::Vector3d(1, -2, 0.7).normalized()).toRotationMatrix();
  const FieldMesh mesh = moved(box({3, 2, 4}), rotation, {100, -20, 3});
  check_valid_with_volume(map_of(mesh, 0.5), 6 * 4 * 8);
  std::mt19937_64 random(7);
  const Parametrization named_anew = map_of(relabelled(mesh, random), 0.5);
  check_valid_with_volume(named_anew, 6 * 4 * 8);
  CHECK(named_anew.integer_unknowns == 3);
  CHECK(named_anew.field.singular.edges.empty());
}

// At a corner of 45 degrees a tet is aligned with one of two features, and its frame says nothing of the
// other.
void test_features_do_not_need_their_frames() {
  CombedField field = prepare(box({2, 2, 2}), {0}).field;
  for (int h = 0; h < field.mesh.half_face_count(); ++h) {
    if (at(field.mesh.twin, h) >= 0) continue;
    Eigen::Matrix3d& frame = at(field.mesh.frames, h / 4);
    frame = Eigen::AngleAxisd(0.9, area_vector(field.mesh, h).normalized()) * frame;
  }
  Elimination elimination = constrain(field);
  CHECK(degenerate_tets(field, reduce(field, elimination)).empty());
}

void test_concave_edge() {
  const Parametrization result = map_of(l_shape(4, 2), 0.5);
  check_valid_with_volume(result, (8 * 8 - 4 * 4) * 4);
  int concave = 0;
  for (const BoundaryEdge& edge : result.field.boundary_edges) {
    concave += sector_quarter_turns(result.field.mesh, edge, result.field.boundary_axis) == 3 ? 1 : 0;
  }
  CHECK(concave > 0);
}

// Legs that are a third of a cell wide keep one cell; their lengths of 5 / 2.9 = 1.7 cells round to two.
void test_thin_leg_survives() {
  const auto keep = [](const Cell& cell) { return cell[0] < 1 || cell[1] < 1; };
  const FieldMesh mesh = field_mesh(grid_mesh({6, 6, 2}, keep), unwarped, constant_frame);
  const Parametrization result = map_of(mesh, 2.9);
  check_valid_with_volume(result, 1 + 2 + 2);
  CHECK(result.violated_rows == 0);
}

void test_cylinder() {
  const FieldMesh mesh = cylinder(8, 4, 0.6);
  const double cell_length = 0.19;  // at 0.2 two roundings cost the same but for rounding errors
  const Parametrization result = map_of(mesh, cell_length);
  CHECK(result.verification.valid());
  CHECK(result.field.singular.arcs.size() == 4);
  for (const SingularArc& arc : result.field.singular.arcs) CHECK(arc.valence == 3);
  CHECK(result.field.singular.nodes.empty());
  // four blocks round a core, five layers: a whole number of hexes
  CHECK_NEAR(result.parametric_volume, std::round(result.parametric_volume), 1e-6);
  CHECK(std::lround(result.parametric_volume) % 5 == 0);
  std::mt19937_64 random(8);
  CHECK_NEAR(map_of(relabelled(mesh, random), cell_length).parametric_volume, result.parametric_volume, 1e-6);
}

void test_every_seam_is_exact() {
  std::mt19937_64 random(9);
  const Parametrization result = map_of(relabelled(cylinder(6, 2, 0.6), random), 0.25);
  CHECK(result.verification.open_seams.empty());
  Parametrization broken = result;
  broken.map.parameters[10][0][0] += 1;  // one unit in the last place
  const Verification verification = verify(broken.field, broken.map);
  CHECK(!verification.open_seams.empty() || !verification.unaligned_faces.empty());
  CHECK(!verification.valid());
}

// Which of the two sides of a plane the solid lies on follows from the map: turned by half a turn, with every
// second normal the other way round, it is as valid as before.
void test_either_side_of_a_plane() {
  Parametrization result = map_of(l_shape(4, 2), 0.5);
  for (auto& corners : result.map.parameters) {
    for (Vector3<Fixed>& u : corners) u = {-u[0], -u[1], u[2]};
  }
  CHECK(verify(result.field, result.map).valid());
}

struct FlatEdge {
  const BoundaryEdge* edge = nullptr;
  double widest_wedge = 1e300;  // of its tets, radians
};

// The edge inside a face of the box whose tets are the thinnest wedges.
FlatEdge sharpest_flat_edge(const CombedField& field) {
  FlatEdge best;
  for (const BoundaryEdge& edge : field.boundary_edges) {
    if (sector_quarter_turns(field.mesh, edge, field.boundary_axis) != 2) continue;
    double widest = 0;
    for (const int h : field.rings.ring(static_cast<std::size_t>(edge.ring))) {
      const Eigen::Vector3d begin = area_vector(
          field.mesh,
          detail::other_half_face(at(field.mesh.tets, h / 4), h, edge.vertices[0], edge.vertices[1]));
      widest = std::max(widest, std::acos(-begin.normalized().dot(area_vector(field.mesh, h).normalized())));
    }
    if (widest < best.widest_wedge) best = {&edge, widest};
  }
  return best;
}

// Half a turn is made a full one round an edge inside a face: its two sides come to lie on each other.
void test_face_folded_onto_itself_is_refused() {
  Parametrization result = map_of(box({2, 2, 2}), 0.25);
  const FlatEdge sharpest = sharpest_flat_edge(result.field);
  CHECK(sharpest.widest_wedge < 1.5);
  const BoundaryEdge& edge = *sharpest.edge;
  const double one = static_cast<double>(Fixed{1} << result.map.fraction_bits);
  const auto point = [&](const Vector3<Fixed>& u) -> Eigen::Vector3d {
    return Eigen::Vector3d(static_cast<double>(u[0]), static_cast<double>(u[1]), static_cast<double>(u[2])) /
           one;
  };
  const int tet = edge.begin_face / 4;
  const auto parameter = [&](int vertex) {
    return point(at(at(result.map.parameters, tet), corner_of(at(result.field.mesh.tets, tet), vertex)));
  };
  const Eigen::Vector3d origin = parameter(edge.vertices[0]);
  const Eigen::Vector3d along = (parameter(edge.vertices[1]) - origin).normalized();
  const SignedAxis outward = at(result.field.boundary_axis, edge.begin_face);
  const Eigen::Vector3d inward = -outward.sign * Eigen::Vector3d::Unit(outward.axis);
  const Eigen::Vector3d aside = inward.cross(along);
  for (auto& corners : result.map.parameters) {
    for (Vector3<Fixed>& u : corners) {
      const Eigen::Vector3d p = point(u) - origin;
      const double x = p.dot(aside), y = p.dot(inward), r = std::hypot(x, y);
      if (r == 0) continue;
      const Eigen::Vector3d moved =
          origin + p.dot(along) * along + (x * x - y * y) / r * aside + 2 * x * y / r * inward;
      for (std::size_t i = 0; i < 3; ++i)
        u[i] = to_fixed(moved(static_cast<Eigen::Index>(i)), result.map.fraction_bits);
    }
  }
  int found = 0;
  for (const Verification::WoundEdge& wound : verify(result.field, result.map).wound_edges)
    found += wound.ring == edge.ring && wound.quarter_turns == 4 ? 1 : 0;
  CHECK(found == 1);
}

// The frames turn by a full turn round the axis of a cylinder, which leaves a cone of angle zero there.
FieldMesh polar_cylinder() {
  FieldMesh mesh = cylinder(8, 2, 0.6);
  for (int t = 0; t < mesh.tet_count(); ++t) {
    const Eigen::Vector3d center = tet_center(mesh, t);
    at(mesh.frames, t) =
        Eigen::AngleAxisd(std::atan2(center.y(), center.x()), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  return mesh;
}

// A field that winds once too often round an edge is refused, though every tet keeps its orientation.
void test_polar_field_is_refused() {
  const Parametrization result =
      solve_prepared(prepare(polar_cylinder(), {0}), {0.25, 0, 1}, [](double, const std::string&) {});
  CHECK(!result.verification.valid());
}

// Diffusion breaks the axis into four singular lines.
void test_polar_field_is_repaired() {
  const Parametrization result = map_of(polar_cylinder(), 0.25);
  CHECK(result.verification.valid());
  CHECK(result.preparation.diffusion_rounds > 0);
  CHECK(result.field.singular.arcs.size() == 4);
}

}  // namespace
}  // namespace neurframe

int main() {
  neurframe::test_box();
  neurframe::test_rigid_motion_and_names_of_axes();
  neurframe::test_features_do_not_need_their_frames();
  neurframe::test_concave_edge();
  neurframe::test_thin_leg_survives();
  neurframe::test_cylinder();
  neurframe::test_every_seam_is_exact();
  neurframe::test_either_side_of_a_plane();
  neurframe::test_face_folded_onto_itself_is_refused();
  neurframe::test_polar_field_is_refused();
  neurframe::test_polar_field_is_repaired();
  return neurframe::test_result();
}
