// From a mesh with frames to one that can carry a map: splits, alignment, matchings, constraints.
#pragma once

#include <limits>
#include <optional>
#include <set>

#include "cubecover/defects.hpp"
#include "cubecover/frame_diffusion.hpp"
#include "cubecover/polycube.hpp"

namespace neurframe {

// How to prepare.  No setting suits every field, so several are judged by the defects that they leave.
struct Preparation {
  int diffusion_rounds = 0;  // of the frames; 0 takes them as they are
  LabelCosts polycube = {};  // of the labels that replace the frames, where compactness is not 0
  int restarts = 0;          // balls whose frames were started anew
  int line_moves = 0;        // of singular lines, after the frames had been matched

  bool is_polycube() const { return polycube.compactness > 0; }
  bool has_matchings() const {
    return is_polycube() || line_moves > 0;
  }  // that do not follow from the frames
};

struct PreparationScore {
  Preparation preparation;
  int tets;
  double defect_score;
};

struct PreparedField {
  FieldMesh
      framed;  // split and with its final frames and matchings, before the splits between singular lines
  CombedField field;
  Elimination elimination;
  ReducedMap map;
  std::vector<Defect> defects;
  Preparation preparation;

  double score() const { return defect_score(defects); }
  PreparationScore judged() const { return {preparation, field.mesh.tet_count(), score()}; }
};

// The field of a mesh whose frames are matched.  It has no map where defects that show before scored more.
PreparedField judged_field(FieldMesh framed, const Preparation& preparation,
                           double most_score = std::numeric_limits<double>::infinity());

double mean_edge_length(const FieldMesh& mesh);

// What searches for a sounder field share: the field so far, what its moves need, and how many may be tried.
class FieldSearch {
 protected:
  // budget: tets that may be prepared again, all tries together.
  FieldSearch(PreparedField& prepared, int budget);

  bool may_try() { return tries_left_-- > 0; }

  // The candidate takes the place of the field where its score is lower.
  bool keep_if_sounder(PreparedField candidate);

  PreparedField& prepared_;
  std::vector<Alignment> alignments_;
  double edge_length_;

 private:
  int tries_left_;
};

// The places of the defects, the gravest first; off-axis edges do no harm by themselves.
std::vector<Eigen::Vector3d> grave_places(std::vector<Defect> defects);

PreparedField prepare(FieldMesh mesh, const Preparation& preparation);

// The preparations to try, in this order: the frames as they are, and diffused.
std::vector<Preparation> usual_preparations();

// The field with frames started anew round its defects, ball by ball, wherever that lowers the defect score.
PreparedField with_local_restarts(PreparedField prepared);

// Polycubes of a solid one after the other, distinct from each other: with labels of different costs, with
// the features inside the labels and without.
class PolycubeSequence {
 public:
  explicit PolycubeSequence(FieldMesh mesh);

  std::optional<PreparedField> next();  // none after the last one

 private:
  FieldMesh next_field();

  FieldMesh mesh_;
  std::size_t taken_ = 0;
  FieldMesh with_features_;
  std::set<std::vector<EdgeKey>> seen_;  // the features of those that were there
};

// A field that was prepared before, with other features.
PreparedField prepare_again(FieldMesh mesh, const Preparation& preparation);

// The same field with the edges of the tets that failed halved, so that the next try has room there.
PreparedField refined_around(const FieldMesh& mesh, const Preparation& preparation,
                             const std::vector<int>& tets);

}  // namespace neurframe
