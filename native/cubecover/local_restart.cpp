#include "cubecover/local_restart.hpp"

#include <utility>

namespace neurframe {

namespace {

constexpr FrameDiffusion settling{12, 0.02, 0.25};

// The tets of a ball, then those behind the ball's faces.
struct Ball {
  std::vector<int> tets;
  std::size_t inside = 0;
  std::size_t rim() const { return tets.size() - inside; }
};

Ball ball_around(const FieldMesh& mesh, const LocalRestart& restart) {
  Ball ball;
  std::vector<char> taken(mesh.tets.size(), 0);
  for (int t = 0; t < mesh.tet_count(); ++t) {
    if ((tet_center(mesh, t) - restart.center).norm() > restart.radius) continue;
    ball.tets.push_back(t);
    at(taken, t) = 1;
  }
  ball.inside = ball.tets.size();
  for (std::size_t i = 0; i < ball.inside; ++i) {
    for (int corner = 0; corner < 4; ++corner) {
      const int twin = at(mesh.twin, 4 * ball.tets[i] + corner);
      if (twin < 0 || at(taken, twin / 4)) continue;
      at(taken, twin / 4) = 1;
      ball.tets.push_back(twin / 4);
    }
  }
  return ball;
}

FieldMesh mesh_of(const FieldMesh& mesh, const Ball& ball) {
  FieldMesh part;
  part.points = mesh.points;
  for (const int t : ball.tets) {
    part.tets.push_back(at(mesh.tets, t));
    part.frames.push_back(at(mesh.frames, t));
  }
  part.twin = half_face_twins(part.tets, part.points.size());
  return part;
}

}  // namespace

bool restart_frames(FieldMesh& mesh, const std::vector<Alignment>& alignments, const LocalRestart& restart) {
  const Ball ball = ball_around(mesh, restart);
  if (ball.inside == 0 || ball.rim() == 0) return false;
  FieldMesh part = mesh_of(mesh, ball);
  const auto source = static_cast<std::size_t>(restart.source * static_cast<double>(ball.rim()));
  std::vector<Alignment> held;
  for (std::size_t i = 0; i < ball.tets.size(); ++i) {
    if (i < ball.inside) {
      part.frames[i] = part.frames[ball.inside + source];
      held.push_back(at(alignments, ball.tets[i]));
    } else {
      held.push_back({part.frames[i].col(0), part.frames[i].col(1)});
    }
  }
  diffuse_frames(part, held, settling);
  for (std::size_t i = 0; i < ball.inside; ++i) at(mesh.frames, ball.tets[i]) = part.frames[i];
  return true;
}

}  // namespace neurframe
