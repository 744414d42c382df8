#include "cubecover/separation.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace neurframe {

namespace {

constexpr double sideways_reach = 0.35;  // cells
constexpr double least_distance = 1e-6;  // cells; nearer things are the source itself
constexpr int most_steps = 10000;        // tets along a ray; a limit cycle would never end

// A ray in the chart of its tet.
struct Ray {
  int tet;
  Eigen::Vector3d point;
  SignedAxis direction;
  Combination source;  // the source's coordinate along the ray, carried into the present chart
  double start;        // its value in the chart where the ray started, carried along like `source`
};

Eigen::Vector3d axis_vector(SignedAxis axis) {
  return axis.sign * Eigen::Vector3d::Unit(axis.axis);
}

// A distance that is always zero is not: the defect gate reports what is squeezed between.
bool is_integral(const Elimination& elimination, const Combination& distance) {
  return !distance.empty() && std::all_of(distance.begin(), distance.end(), [&](const Term& term) {
    return elimination.is_integer(term.unknown) && term.coefficient.denominator == 1;
  });
}

SeparationRow row_of(const ReducedMap& map, const Combination& distance) {
  SeparationRow row;
  for (const Rational& coefficient : integer_row(map, distance)) row.push_back(coefficient.value());
  return row;
}

class RayCaster {
 public:
  RayCaster(const CombedField& field, Elimination& elimination, const ReducedMap& map,
            const Eigen::VectorXd& rows)
      : field_(field), mesh_(field.mesh), elimination_(elimination), map_(map), rows_(rows) {
    critical_.assign(field.rings.vertices.size(), 0);
    for (const SingularEdge& edge : field.singular.edges) at(critical_, edge.ring) = 1;
    for (const BoundaryEdge& edge : field.boundary_edges) {
      at(critical_, edge.ring) = is_feature(mesh_, edge_key(edge.vertices[0], edge.vertices[1]));
    }
  }

  std::vector<SeparationRow> cast_all() {
    for (int h = 0; h < mesh_.half_face_count(); ++h) {
      const SignedAxis outward = at(field_.boundary_axis, h);
      if (outward.axis < 0) continue;
      const auto corners = at(face_corners, h % 4);
      const Eigen::Matrix<double, 3, 4> u = corner_parameters(map_, rows_, h / 4);
      const Eigen::Vector3d center = (u.col(corners[0]) + u.col(corners[1]) + u.col(corners[2])) / 3;
      cast(h / 4, corners[0], center, {outward.axis, -outward.sign});
    }
    for (int e = 0; e < static_cast<int>(critical_.size()); ++e) {
      if (at(critical_, e)) cast_from_edge(e);
    }
    return {found_.begin(), found_.end()};
  }

 private:
  Combination coordinate(int tet, int corner, SignedAxis axis) {
    const Combination resolved = elimination_.resolve(coordinate_unknown(field_, tet, corner, axis.axis));
    return add_scaled({}, Rational(axis.sign), resolved);
  }

  // The chart axis along an edge whose other two coordinates are constant; -1 for an edge of no length.
  static int axis_along(const Eigen::Vector3d& edge) {
    int axis = -1;
    return edge.cwiseAbs().maxCoeff(&axis) > least_distance ? axis : -1;
  }

  // From the middle of the edge, in each tet of its ring, along the transverse axes that point into that tet.
  void cast_from_edge(int edge) {
    const EdgeKey ends = at(field_.rings.vertices, edge);
    for (const int h : field_.rings.ring(static_cast<std::size_t>(edge))) {
      const Tet& tet = at(mesh_.tets, h / 4);
      const int a = corner_of(tet, ends[0]);
      const int b = corner_of(tet, ends[1]);
      const Eigen::Matrix<double, 3, 4> u = corner_parameters(map_, rows_, h / 4);
      const int along = axis_along(u.col(b) - u.col(a));
      if (along < 0) continue;
      const Eigen::Vector3d middle = (u.col(a) + u.col(b)) / 2;
      const Eigen::Vector3d first = u.col(h % 4) - middle;
      const Eigen::Vector3d last = u.col(6 - a - b - h % 4) - middle;
      for (const int axis : {(along + 1) % 3, (along + 2) % 3}) {
        for (const int sign : {1, -1}) {
          const Eigen::Vector3d direction = sign * Eigen::Vector3d::Unit(axis);
          const Eigen::Vector3d edge_vector = u.col(b) - u.col(a);
          // between the two faces at the edge, as seen along it
          const bool inside =
              edge_vector.dot(first.cross(direction)) >= 0 && edge_vector.dot(direction.cross(last)) > 0;
          if (inside) cast(h / 4, a, middle, {axis, sign});
        }
      }
    }
  }

  void cast(int tet, int source_corner, const Eigen::Vector3d& point, SignedAxis direction) {
    Ray ray{tet, point, direction, coordinate(tet, source_corner, direction),
            axis_vector(direction).dot(point)};
    int entered = -1;
    for (int step = 0; step < most_steps; ++step) {
      const Eigen::Matrix<double, 3, 4> u = corner_parameters(map_, rows_, ray.tet);
      meet_edges(ray, u);
      const int exit = exit_face(ray, u, entered);
      if (exit < 0) return;
      const int half_face = 4 * ray.tet + exit;
      if (at(mesh_.twin, half_face) < 0) {
        if (at(field_.boundary_axis, half_face).axis == ray.direction.axis) {
          meet(ray, coordinate(ray.tet, at(face_corners, exit)[0], ray.direction));
        }
        return;
      }
      entered = at(mesh_.twin, half_face) % 4;
      cross(ray, u, half_face);
    }
  }

  // The face that the ray leaves the tet through; -1 in a folded or flat tet.
  static int exit_face(const Ray& ray, const Eigen::Matrix<double, 3, 4>& u, int entered) {
    const Eigen::Matrix3d edges = u.rightCols<3>().colwise() - u.col(0);
    if (!(edges.determinant() > 0)) return -1;
    const Eigen::Matrix3d inverse = edges.inverse();
    Eigen::Vector4d position;
    Eigen::Vector4d speed;
    position.tail<3>() = inverse * (ray.point - u.col(0));
    speed.tail<3>() = inverse * axis_vector(ray.direction);
    position(0) = 1 - position.tail<3>().sum();
    speed(0) = -speed.tail<3>().sum();
    int exit = -1;
    double first_time = 0;
    for (int face = 0; face < 4; ++face) {
      if (face == entered || !(speed(face) < 0)) continue;
      const double time = std::max(0.0, position(face)) / -speed(face);
      if (exit >= 0 && time >= first_time) continue;
      exit = face;
      first_time = time;
    }
    return exit;
  }

  // Moves the ray to the exit face and into the neighbour's chart: v_neighbour = R v + j.
  void cross(Ray& ray, const Eigen::Matrix<double, 3, 4>& u, int half_face) {
    const int twin = at(mesh_.twin, half_face);
    const OctahedralRotation rotation = at(mesh_.matchings, half_face);
    const auto corners = at(face_corners, half_face % 4);
    const Eigen::Vector3d normal =
        (u.col(corners[1]) - u.col(corners[0])).cross(u.col(corners[2]) - u.col(corners[0]));
    const double time = normal.dot(u.col(corners[0]) - ray.point) / normal.dot(axis_vector(ray.direction));
    const Eigen::Vector3d exit_point = ray.point + time * axis_vector(ray.direction);
    const int vertex = at(at(mesh_.tets, ray.tet), corners[0]);
    const int other_corner = corner_of(at(mesh_.tets, twin / 4), vertex);
    const Eigen::Vector3d there = corner_parameters(map_, rows_, twin / 4).col(other_corner);
    const SignedAxis direction = carried(rotation, ray.direction);
    if (at(field_.cut, half_face)) {
      const Combination translation = add_scaled(coordinate(twin / 4, other_corner, direction), Rational(-1),
                                                 coordinate(ray.tet, corners[0], ray.direction));
      ray.source = add_scaled(ray.source, Rational(1), translation);
      ray.start += axis_vector(direction).dot(there) - axis_vector(ray.direction).dot(u.col(corners[0]));
    }
    ray.point = there + to_matrix(rotation) * (exit_point - u.col(corners[0]));
    ray.direction = direction;
    ray.tet = twin / 4;
  }

  // Critical edges of the present tet that the ray passes closely.
  void meet_edges(const Ray& ray, const Eigen::Matrix<double, 3, 4>& u) {
    for (std::size_t k = 0; k < 6; ++k) {
      if (!at(critical_, at(field_.rings.edge_of_tet, ray.tet)[k])) continue;
      const auto [a, b] = tet_edges[k];
      const int along = axis_along(u.col(b) - u.col(a));
      if (along < 0 || along == ray.direction.axis) continue;
      const int sideways = 3 - along - ray.direction.axis;
      const auto [low, high] = std::minmax(u(along, a), u(along, b));
      const bool beside = std::abs(u(sideways, a) - ray.point(sideways)) < sideways_reach &&
                          ray.point(along) >= low && ray.point(along) <= high;
      const double distance = ray.direction.sign * u(ray.direction.axis, a) - ray.start;
      if (beside && distance > least_distance) meet(ray, coordinate(ray.tet, a, ray.direction));
    }
  }

  void meet(const Ray& ray, const Combination& target) {
    const Combination distance = add_scaled(target, Rational(-1), ray.source);
    if (is_integral(elimination_, distance)) found_.insert(row_of(map_, distance));
  }

  const CombedField& field_;
  const FieldMesh& mesh_;
  Elimination& elimination_;
  const ReducedMap& map_;
  const Eigen::VectorXd& rows_;
  std::vector<char> critical_;  // per ring
  std::set<SeparationRow> found_;
};

}  // namespace

std::vector<SeparationRow> separation_rows(const CombedField& field, Elimination& elimination,
                                           const ReducedMap& map, const Eigen::VectorXd& rows) {
  return RayCaster(field, elimination, map, rows).cast_all();
}

std::vector<SeparationRow> collapsed_rows(const CombedField& field, Elimination& elimination,
                                          const ReducedMap& map, const Eigen::VectorXd& seamless_rows,
                                          const Eigen::VectorXd& rounded_rows, const std::vector<int>& tets) {
  std::set<SeparationRow> found;
  for (const int tet : tets) {
    const Eigen::Matrix<double, 3, 4> apart = corner_parameters(map, seamless_rows, tet);
    const Eigen::Matrix<double, 3, 4> together = corner_parameters(map, rounded_rows, tet);
    double farthest = least_distance;
    SeparationRow row;
    for (const auto& [a, b] : tet_edges) {
      for (int axis = 0; axis < 3; ++axis) {
        const double gap = apart(axis, a) - apart(axis, b);
        const bool collapsed = std::abs(together(axis, a) - together(axis, b)) < least_distance;
        if (!collapsed || std::abs(gap) <= farthest) continue;
        const Combination distance =
            add_scaled(elimination.resolve(coordinate_unknown(field, tet, a, axis)), Rational(-1),
                       elimination.resolve(coordinate_unknown(field, tet, b, axis)));
        if (!is_integral(elimination, distance)) continue;
        farthest = std::abs(gap);
        row = row_of(map, add_scaled({}, Rational(gap > 0 ? 1 : -1), distance));
      }
    }
    if (!row.empty()) found.insert(std::move(row));
  }
  return {found.begin(), found.end()};
}

}  // namespace neurframe
