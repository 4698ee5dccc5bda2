// Coal 3 (PyPI wheel `coal`: its headers and its library). First argument: the volume, obb | rss | obbrss | kios | aabb.
//
// OBB, OBBRSS and kIOS keep their trees in the mesh's frame and carry the pose through the traversal; RSS does so for distances
// only, and is only asked for those. For AABB, Coal copies and re-fits the whole tree at each query: it carries `refit` in its
// name.
#include <coal/BVH/BVH_model.h>
#include <coal/collision.h>
#include <coal/distance.h>

#include <limits>

#include "runner.hpp"

using peers::Mode;

// Whether the volume's tree stays in its frame (or may be re-fitted, by name) in collision queries, and in distance queries.
template <class Volume, bool collides, bool measures> struct Coal {
  using Pose = coal::Transform3s;
  using Model = coal::BVHModel<Volume>;

  // Coal has no search along a motion: it advances by its distances.
  static bool has(Mode mode) { return mode == Mode::distance || mode == Mode::motion ? measures : collides; }

  static Pose pose(const peers::Matrix& matrix) {
    coal::Matrix3s rotation;
    coal::Vec3s translation;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) rotation(i, j) = matrix[i][j];
      translation[i] = matrix[i][3];
    }
    return Pose(rotation, translation);
  }

  Coal(const peers::Mesh& a, const peers::Mesh& b) : a_(build(a)), b_(build(b)) {}

  void forget() {}

  double answer(Mode mode, const Pose& a_from_b) {
    if (mode == Mode::distance) {
      coal::DistanceRequest request(false, false);
      coal::DistanceResult result;
      return std::max(0.0, coal::distance(a_.get(), identity_, b_.get(), a_from_b, request, result));
    }
    const std::size_t most = mode == Mode::all ? std::numeric_limits<std::size_t>::max() : 1;
    coal::CollisionRequest request(coal::NO_REQUEST, most);
    coal::CollisionResult result;
    return static_cast<double>(coal::collide(a_.get(), identity_, b_.get(), a_from_b, request, result));
  }

  std::size_t bytes() const { return static_cast<std::size_t>(a_->memUsage(false) + b_->memUsage(false)); }

 private:
  static std::unique_ptr<Model> build(const peers::Mesh& mesh) {
    std::vector<coal::Vec3s> vertices;
    std::vector<coal::Triangle> faces;
    for (const auto& v : mesh.vertices) vertices.emplace_back(v[0], v[1], v[2]);
    for (const auto& f : mesh.faces) faces.emplace_back(f[0], f[1], f[2]);
    std::unique_ptr<Model> model(new Model);
    model->beginModel(static_cast<unsigned>(faces.size()), static_cast<unsigned>(vertices.size()));
    model->addSubModel(vertices, faces);
    model->endModel();
    return model;
  }

  std::unique_ptr<Model> a_, b_;
  Pose identity_;
};

int main(int count, char** words) {
  std::vector<std::string> arguments(words + 1, words + count);
  const std::string volume = arguments.empty() ? "" : arguments[0];
  if (!arguments.empty()) arguments.erase(arguments.begin());
  if (volume == "obb") return peers::serve<Coal<coal::OBB, true, false>>(arguments);
  if (volume == "rss") return peers::serve<Coal<coal::RSS, false, true>>(arguments);
  if (volume == "obbrss") return peers::serve<Coal<coal::OBBRSS, true, true>>(arguments);
  if (volume == "kios") return peers::serve<Coal<coal::kIOS, true, true>>(arguments);
  if (volume == "aabb") return peers::serve<Coal<coal::AABB, true, false>>(arguments);
  std::cerr << "error: the first argument is obb, rss, obbrss, kios or aabb\n";
  return 2;
}
