// PQP 1.3 (University of North Carolina), compiled together with this file from the source folder that PQP_SOURCE names: OBB trees for contact, trees of
// rectangles with a radius (RSS) for distances.
#include <PQP.h>

#include "runner.hpp"

using peers::Mode;

struct Pqp {
  struct Pose {
    PQP_REAL rotation[3][3], translation[3];
  };

  static bool has(Mode) { return true; }

  static Pose pose(const peers::Matrix& matrix) {
    Pose pose = {};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) pose.rotation[i][j] = matrix[i][j];
      pose.translation[i] = matrix[i][3];
    }
    return pose;
  }

  Pqp(const peers::Mesh& a, const peers::Mesh& b) {
    build(a, a_);
    build(b, b_);
  }

  void forget() {}

  double answer(Mode mode, const Pose& a_from_b) {
    // PQP takes its arguments as variable and leaves them alone.
    Pose& pose = const_cast<Pose&>(a_from_b);
    if (mode == Mode::distance) {
      PQP_DistanceResult result;
      PQP_Distance(&result, still_.rotation, still_.translation, &a_, pose.rotation, pose.translation, &b_, 0, 0);
      return result.Distance();
    }
    found_.num_pairs = 0;
    PQP_Collide(&found_, still_.rotation, still_.translation, &a_, pose.rotation, pose.translation, &b_,
                mode == Mode::all ? PQP_ALL_CONTACTS : PQP_FIRST_CONTACT);
    return found_.NumPairs();
  }

  std::size_t bytes() const { return static_cast<std::size_t>(a_.MemUsage(0) + b_.MemUsage(0)); }

 private:
  static void build(const peers::Mesh& mesh, PQP_Model& model) {
    model.BeginModel(static_cast<int>(mesh.faces.size()));
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      const auto& face = mesh.faces[i];
      const auto corner = [&](int k) { return mesh.vertices[face[k]].data(); };
      model.AddTri(corner(0), corner(1), corner(2), static_cast<int>(i));
    }
    model.EndModel();
  }

  // Mutable since `MemUsage` is not const.
  mutable PQP_Model a_, b_;
  // Kept, so that its list of pairs is made once.
  PQP_CollideResult found_;
  Pose still_ = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
};

int main(int count, char** words) { return peers::serve<Pqp>(std::vector<std::string>(words + 1, words + count)); }
