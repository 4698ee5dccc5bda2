// ODE 0.16 (Debian libode-dev, double precision) with OPCODE: trees of quantised single-precision boxes around single-precision
// triangles; dCollide, which goes on to make contact points, asked for one unimportant contact.
#include <ode/ode.h>

#include "runner.hpp"

using peers::Mode;

struct Ode {
  struct Pose {
    dMatrix3 rotation;
    dVector3 translation;
  };

  static bool has(Mode mode) { return mode == Mode::first || mode == Mode::path; }

  static Pose pose(const peers::Matrix& matrix) {
    Pose pose = {};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) pose.rotation[4 * i + j] = matrix[i][j];
      pose.translation[i] = matrix[i][3];
    }
    return pose;
  }

  Ode(const peers::Mesh& a, const peers::Mesh& b) : a_(a), b_(b) {}

  void forget() {}

  double answer(Mode, const Pose& a_from_b) {
    dGeomSetRotation(b_.geom, a_from_b.rotation);
    dGeomSetPosition(b_.geom, a_from_b.translation[0], a_from_b.translation[1], a_from_b.translation[2]);
    dContactGeom contact;
    return dCollide(a_.geom, b_.geom, 1 | CONTACTS_UNIMPORTANT, &contact, sizeof contact) > 0 ? 1 : 0;
  }

  std::size_t bytes() const { return 0; }

 private:
  // A mesh as ODE holds it.
  struct Body {
    explicit Body(const peers::Mesh& mesh) : data(dGeomTriMeshDataCreate()) {
      for (const auto& v : mesh.vertices) vertices.insert(vertices.end(), v.begin(), v.end());
      for (const auto& f : mesh.faces) faces.insert(faces.end(), f.begin(), f.end());
      dGeomTriMeshDataBuildDouble(data, vertices.data(), 3 * sizeof(double), static_cast<int>(mesh.vertices.size()),
                                  faces.data(), static_cast<int>(faces.size()), 3 * sizeof(dTriIndex));
      geom = dCreateTriMesh(nullptr, data, nullptr, nullptr, nullptr);
    }
    ~Body() {
      dGeomDestroy(geom);
      dGeomTriMeshDataDestroy(data);
    }
    std::vector<double> vertices;
    std::vector<dTriIndex> faces;
    dTriMeshDataID data;
    dGeomID geom = nullptr;
  };

  Body a_, b_;
};

int main(int count, char** words) {
  dInitODE2(0);
  return peers::serve<Ode>(std::vector<std::string>(words + 1, words + count));
}
