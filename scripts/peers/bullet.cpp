// Bullet 3.24 (Debian libbullet-dev, the double-precision build): two GImpact meshes, whose trees of quantised boxes are tested
// against each other; contactPairTest finds all their contacts, as it has no query that stops at the first one.
//
// Margins are 0. A contact is counted when its distance is not positive. Meshes farther apart than their bounding boxes are
// told apart by those, as Bullet's broad phase would.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include "runner.hpp"

using peers::Mode;

// A mesh as Bullet holds it.
struct Body {
  explicit Body(const peers::Mesh& mesh) {
    for (const auto& v : mesh.vertices) vertices.insert(vertices.end(), v.begin(), v.end());
    for (const auto& f : mesh.faces) faces.insert(faces.end(), f.begin(), f.end());
    btIndexedMesh part;
    part.m_numTriangles = static_cast<int>(mesh.faces.size());
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(faces.data());
    part.m_triangleIndexStride = 3 * sizeof(int);
    part.m_numVertices = static_cast<int>(mesh.vertices.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices.data());
    part.m_vertexStride = 3 * sizeof(double);
    part.m_vertexType = PHY_DOUBLE;
    triangles.addIndexedMesh(part, PHY_INTEGER);
    shape.reset(new btGImpactMeshShape(&triangles));
    shape->setMargin(0);
    shape->updateBound();
    object.setCollisionShape(shape.get());
    object.setContactProcessingThreshold(0);
  }

  std::vector<double> vertices;
  std::vector<int> faces;
  btTriangleIndexVertexArray triangles;
  std::unique_ptr<btGImpactMeshShape> shape;
  btCollisionObject object;
};

struct Bullet {
  using Pose = btTransform;

  static bool has(Mode mode) { return mode == Mode::first || mode == Mode::path || mode == Mode::batch; }

  static Pose pose(const peers::Matrix& m) {
    const btMatrix3x3 rotation(m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]);
    return Pose(rotation, btVector3(m[0][3], m[1][3], m[2][3]));
  }

  Bullet(const peers::Mesh& a, const peers::Mesh& b)
      : dispatcher_(&configuration_), world_(&dispatcher_, &broadphase_, &configuration_), a_(a), b_(b) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    // `contactPairTest` looks among the algorithms for closest points, where the line above registers nothing.
    for (int other = 0; other < MAX_BROADPHASE_COLLISION_TYPES; ++other) {
      dispatcher_.registerClosestPointsCreateFunc(GIMPACT_SHAPE_PROXYTYPE, other, &gimpact_);
      dispatcher_.registerClosestPointsCreateFunc(other, GIMPACT_SHAPE_PROXYTYPE, &gimpact_);
    }
    a_.object.setWorldTransform(Pose::getIdentity());
  }

  void forget() {}

  double answer(Mode, const Pose& a_from_b) {
    b_.object.setWorldTransform(a_from_b);
    btVector3 low_a, high_a, low_b, high_b;
    a_.shape->getAabb(a_.object.getWorldTransform(), low_a, high_a);
    b_.shape->getAabb(a_from_b, low_b, high_b);
    if (!TestAabbAgainstAabb2(low_a, high_a, low_b, high_b)) return 0;
    Touching touching;
    world_.contactPairTest(&a_.object, &b_.object, touching);
    return touching.found ? 1 : 0;
  }

  std::size_t bytes() const { return 0; }

 private:
  struct Touching : btCollisionWorld::ContactResultCallback {
    bool found = false;
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
      found = found || point.getDistance() <= 0;
      return 0;
    }
  };

  btGImpactCollisionAlgorithm::CreateFunc gimpact_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_;
  Body a_, b_;
};

int main(int count, char** words) { return peers::serve<Bullet>(std::vector<std::string>(words + 1, words + count)); }
