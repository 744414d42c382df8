#include "cubecover/frame_diffusion.hpp"

#include <cmath>

#include "cubecover/octahedral_coefficients.hpp"

namespace neurframe {

namespace {

using CoefficientField = Eigen::Matrix<double, 9, Eigen::Dynamic>;  // a column per tet

constexpr double least_residual = 1e-3;  // of the first one
constexpr int most_solver_steps = 100;

class Diffusion {
 public:
  Diffusion(FieldMesh& mesh, const std::vector<Alignment>& alignments)
      : mesh_(mesh), fixed_(mesh.tets.size(), 0), about_axis_(mesh.tets.size()) {
    for (int t = 0; t < mesh.tet_count(); ++t) {
      const Alignment& alignment = at(alignments, t);
      at(mesh.frames, t) = aligned_frame(at(mesh.frames, t), alignment);
      at(fixed_, t) = alignment.second.has_value();
      if (alignment.first && !alignment.second) {
        int column = 0;
        (at(mesh.frames, t).transpose() * *alignment.first).cwiseAbs().maxCoeff(&column);
        at(about_axis_, t).emplace(at(mesh.frames, t), column);
      }
    }
    set_weights();
  }

  void run(const FrameDiffusion& diffusion) {
    for (int round = 0; round < diffusion.rounds; ++round) {
      const double share = diffusion.rounds > 1 ? static_cast<double>(round) / (diffusion.rounds - 1) : 0.0;
      const double stiffness =
          diffusion.first_stiffness * std::pow(diffusion.last_stiffness / diffusion.first_stiffness, share);
      project(diffused(stiffness));
    }
  }

 private:
  // Of the dual graph: area of the shared face over the distance of the centres.
  void set_weights() {
    weight_.assign(mesh_.twin.size(), 0);
    degree_ = Eigen::VectorXd::Zero(mesh_.tet_count());
    mass_ = Eigen::VectorXd::Zero(mesh_.tet_count());
    for (int h = 0; h < mesh_.half_face_count(); ++h) {
      if (at(mesh_.twin, h) < 0) continue;
      const double distance = (tet_center(mesh_, h / 4) - tet_center(mesh_, at(mesh_.twin, h) / 4)).norm();
      at(weight_, h) = area_vector(mesh_, h).norm() / distance;
      degree_(h / 4) += at(weight_, h);
    }
    for (int t = 0; t < mesh_.tet_count(); ++t) mass_(t) = tet_volume(mesh_, t);
    mass_ *= degree_.mean() / mass_.mean();
  }

  // The part of a change that the alignment leaves free.
  void make_admissible(CoefficientField& change) const {
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      if (at(fixed_, t)) change.col(t).setZero();
      if (at(about_axis_, t)) change.col(t) = at(about_axis_, t)->tangential(change.col(t));
    }
  }

  // (L + stiffness M) q
  CoefficientField product(const CoefficientField& q, double stiffness) const {
    CoefficientField image(9, q.cols());
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      image.col(t) = (degree_(t) + stiffness * mass_(t)) * q.col(t);
      for (int h = 4 * t; h < 4 * t + 4; ++h) {
        if (at(mesh_.twin, h) >= 0) image.col(t) -= at(weight_, h) * q.col(at(mesh_.twin, h) / 4);
      }
    }
    return image;
  }

  // The minimum of q^T L q + stiffness (q - q0)^T M (q - q0) by conjugate gradients.
  CoefficientField diffused(double stiffness) const {
    CoefficientField q(9, mesh_.tet_count());
    for (int t = 0; t < mesh_.tet_count(); ++t) q.col(t) = coefficients_of(at(mesh_.frames, t));
    CoefficientField residual = product(q, 0) * -1;
    make_admissible(residual);
    const Eigen::RowVectorXd inverse_diagonal = (degree_ + stiffness * mass_).cwiseInverse().transpose();
    CoefficientField scaled = residual.array().rowwise() * inverse_diagonal.array();
    CoefficientField direction = scaled;
    double size = residual.cwiseProduct(scaled).sum();
    const double enough = least_residual * least_residual * size;
    for (int iteration = 0; iteration < most_solver_steps && size > enough; ++iteration) {
      CoefficientField image = product(direction, stiffness);
      make_admissible(image);
      const double step = size / direction.cwiseProduct(image).sum();
      q += step * direction;
      residual -= step * image;
      scaled = residual.array().rowwise() * inverse_diagonal.array();
      const double next = residual.cwiseProduct(scaled).sum();
      direction = scaled + (next / size) * direction;
      size = next;
    }
    return q;
  }

  void project(const CoefficientField& q) {
    for (int t = 0; t < mesh_.tet_count(); ++t) {
      if (at(fixed_, t)) continue;
      const std::optional<FramesAboutAxis>& about_axis = at(about_axis_, t);
      at(mesh_.frames, t) = about_axis ? about_axis->frame(about_axis->nearest_angle(q.col(t)))
                                       : nearest_frame(q.col(t), at(mesh_.frames, t));
    }
  }

  FieldMesh& mesh_;
  std::vector<char> fixed_;                                 // both axes are given
  std::vector<std::optional<FramesAboutAxis>> about_axis_;  // one is
  std::vector<double> weight_;                              // per half-face
  Eigen::VectorXd degree_;
  Eigen::VectorXd mass_;
};

}  // namespace

void diffuse_frames(FieldMesh& mesh, const std::vector<Alignment>& alignments,
                    const FrameDiffusion& diffusion) {
  Diffusion(mesh, alignments).run(diffusion);
}

}  // namespace neurframe
