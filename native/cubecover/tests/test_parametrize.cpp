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
  CombedField field = prepare(box({2, 2, 2}), {0, 0}).field;
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
  const Parametrization result = map_of(mesh, 0.2);
  CHECK(result.verification.valid());
  CHECK(result.field.singular.arcs.size() == 4);
  for (const SingularArc& arc : result.field.singular.arcs) CHECK(arc.valence == 3);
  CHECK(result.field.singular.nodes.empty());
  // four blocks round a core, five layers: a whole number of hexes
  CHECK_NEAR(result.parametric_volume, std::round(result.parametric_volume), 1e-6);
  CHECK(std::lround(result.parametric_volume) % 5 == 0);
  std::mt19937_64 random(8);
  CHECK_NEAR(map_of(relabelled(mesh, random), 0.2).parametric_volume, result.parametric_volume, 1e-6);
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
      solve_prepared(prepare(polar_cylinder(), {0, 0}), {0.25, 0, 1}, [](double, const std::string&) {});
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
  neurframe::test_polar_field_is_refused();
  neurframe::test_polar_field_is_repaired();
  return neurframe::test_result();
}
