// FCL 0.7 (Debian libfcl-dev). First argument: the volume, obb | rss | obbrss | kios | aabb | dop18, or one of FCL's own searches along a motion: rss-advancing |
// obbrss-advancing (conservative advancement) | obbrss-sampled (its default: collision at 100 times).
//
// OBB, OBBRSS and kIOS keep their trees in the mesh's frame and carry the pose through the traversal; RSS does so for distances
// only, and is only asked for those. For AABB and k-DOP, FCL copies and re-fits the whole tree at each query: they carry
// `refit` in their names.
#include <fcl/fcl.h>

#include "runner.hpp"

using peers::Mode;

// Whether the volume's tree stays in its frame (or may be re-fitted, by name) in collision queries, and in distance queries.
template <class Volume, bool collides, bool measures> struct Fcl {
  using Pose = fcl::Transform3d;
  using Model = fcl::BVHModel<Volume>;

  static bool has(Mode mode) { return mode == Mode::distance || mode == Mode::motion ? measures : collides; }

  static Pose pose(const peers::Matrix& matrix) {
    Pose pose = Pose::Identity();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) pose(i, j) = matrix[i][j];
    return pose;
  }

  Fcl(const peers::Mesh& a, const peers::Mesh& b) : a_(build(a)), b_(build(b)) {}

  void forget() {}

  double answer(Mode mode, const Pose& a_from_b) {
    if (mode == Mode::distance) {
      fcl::DistanceRequestd request;
      fcl::DistanceResultd result;
      return std::max(0.0, fcl::distance(a_.get(), identity_, b_.get(), a_from_b, request, result));
    }
    const std::size_t most = mode == Mode::all ? std::numeric_limits<std::size_t>::max() : 1;
    fcl::CollisionRequestd request(most, false);
    fcl::CollisionResultd result;
    return static_cast<double>(fcl::collide(a_.get(), identity_, b_.get(), a_from_b, request, result));
  }

  std::size_t bytes() const { return static_cast<std::size_t>(a_->memUsage(0) + b_->memUsage(0)); }

 protected:
  static std::unique_ptr<Model> build(const peers::Mesh& mesh) {
    std::vector<fcl::Vector3d> vertices;
    std::vector<fcl::Triangle> faces;
    for (const auto& v : mesh.vertices) vertices.emplace_back(v[0], v[1], v[2]);
    for (const auto& f : mesh.faces) faces.emplace_back(f[0], f[1], f[2]);
    std::unique_ptr<Model> model(new Model);
    model->beginModel(static_cast<int>(faces.size()), static_cast<int>(vertices.size()));
    model->addSubModel(vertices, faces);
    model->endModel();
    return model;
  }

  std::unique_ptr<Model> a_, b_;
  Pose identity_ = Pose::Identity();
};

// FCL's own search along a motion.
template <class Volume, fcl::CCDSolverType solver> struct Moving : Fcl<Volume, true, true> {
  static bool has(Mode mode) { return mode == Mode::motion; }

  using Fcl<Volume, true, true>::Fcl;

  double motion(const peers::Motion& motion) {
    // The constructor with a point about which it turns: the others leave the point, or the speeds, as memory is.
    const auto from = this->pose(motion.start), to = this->pose(motion.end);
    const fcl::Vector3d origin = fcl::Vector3d::Zero();
    const fcl::Matrix3d identity = fcl::Matrix3d::Identity();
    const fcl::InterpMotion<double> still(identity, origin, identity, origin, origin);
    const fcl::InterpMotion<double> moved(from.linear(), from.translation(), to.linear(), to.translation(), origin);
    const fcl::ContinuousCollisionRequestd request(samples, 1e-5, fcl::CCDM_LINEAR, fcl::GST_LIBCCD, solver);
    fcl::ContinuousCollisionResultd result;
    const double time = fcl::continuousCollide(this->a_.get(), &still, this->b_.get(), &moved, request, result);
    return result.is_collide ? time : std::numeric_limits<double>::infinity();
  }

  // The times at which the sampling solver looks; conservative advancement does not read it.
  static constexpr std::size_t samples = 100;
};

int main(int count, char** words) {
  std::vector<std::string> arguments(words + 1, words + count);
  const std::string volume = arguments.empty() ? "" : arguments[0];
  if (!arguments.empty()) arguments.erase(arguments.begin());
  if (volume == "obb") return peers::serve<Fcl<fcl::OBBd, true, false>>(arguments);
  if (volume == "rss") return peers::serve<Fcl<fcl::RSSd, false, true>>(arguments);
  if (volume == "obbrss") return peers::serve<Fcl<fcl::OBBRSSd, true, true>>(arguments);
  if (volume == "kios") return peers::serve<Fcl<fcl::kIOSd, true, true>>(arguments);
  if (volume == "aabb") return peers::serve<Fcl<fcl::AABBd, true, false>>(arguments);
  if (volume == "dop18") return peers::serve<Fcl<fcl::KDOP<double, 18>, true, false>>(arguments);
  if (volume == "rss-advancing") return peers::serve<Moving<fcl::RSSd, fcl::CCDC_CONSERVATIVE_ADVANCEMENT>>(arguments);
  if (volume == "obbrss-advancing") return peers::serve<Moving<fcl::OBBRSSd, fcl::CCDC_CONSERVATIVE_ADVANCEMENT>>(arguments);
  if (volume == "obbrss-sampled") return peers::serve<Moving<fcl::OBBRSSd, fcl::CCDC_NAIVE>>(arguments);
  std::cerr << "error: the first argument is obb, rss, obbrss, kios, aabb, dop18, rss-advancing, obbrss-advancing or obbrss-sampled\n";
  return 2;
}
