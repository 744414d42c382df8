// The seamless map reduced to its critical vertices: the decimated triangulation of Coudert-Osmont et al.
// 2023, "Quad mesh quantization without a T-mesh".
#pragma once

#include <Eigen/Core>
#include <set>
#include <vector>

#include "miq/intrinsic_triangulation.hpp"
#include "miq/map_problem.hpp"

namespace neurframe {

// combination of integer variables, with a constant, that must be at least 1
using SeparationRow = IntegerCombination;

struct RowOrder {
  bool operator()(const SeparationRow& a, const SeparationRow& b) const { return a.terms < b.terms; }
};
using SeparationRows = std::set<SeparationRow, RowOrder>;

// Integers can be realised by a locally injective map if the flat metric that they give the triangulation
// can be reached from that of the seamless map by a motion in which no triangle collapses for good: triangles
// that would are avoided by flips, unless a vertex runs into a feature or another vertex.
class CriticalTriangulation {
 public:
  // Removes every vertex of the seamless map that is not critical: not singular, no end or crossing of
  // features, and not the only one left on a closed feature line or a component.
  CriticalTriangulation(const MapProblem& problem, const Eigen::VectorXd& real,
                        const Eigen::VectorXd& integer);

  // The rows that keep apart what is at most `reach` cells apart: vertices, and vertices from features.
  SeparationRows near_rows(double reach) const;

  // Moves the metric to other unknowns, and returns for every triangle that collapses for good the row that
  // would have prevented it; `collapsed` counts them, also those that no row of integers can prevent.
  SeparationRows broken_rows(const Eigen::VectorXd& real, const Eigen::VectorXd& integer,
                             int& collapsed) const;

  int triangle_count() const { return mesh_.triangle_count(); }
  // how many others could not be removed
  int vertices_left() const { return vertices_left_; }

 private:
  Fixed value(const IntegerCombination& x, const Eigen::VectorXd& real, const Eigen::VectorXd& integer) const;
  bool in_integers(const IntegerCombination& x) const;
  void keep_apart(const IntrinsicTriangulation& mesh, int h, double t, SeparationRows& rows) const;
  void keep_from_line(const IntrinsicTriangulation& mesh, int line, double t, SeparationRows& rows) const;
  void prevent(const IntrinsicTriangulation& mesh, int f, double t, double collapse,
               SeparationRows& rows) const;

  IntrinsicTriangulation mesh_;
  int integer_count_;
  int fraction_bits_;
  int vertices_left_ = 0;
};

}  // namespace neurframe
