// CGAL 5.5 (Debian libcgal-dev): Rigid_triangle_mesh_collision_detection, trees of axis-aligned boxes that are moved during
// the traversal, on the kernel with exact predicates. Exact for the vertices as moved in double precision.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Rigid_triangle_mesh_collision_detection.h>
#include <CGAL/Surface_mesh.h>

#include "runner.hpp"

using peers::Mode;

struct Cgal {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
  using Pose = CGAL::Aff_transformation_3<Kernel>;

  static bool has(Mode mode) { return mode == Mode::first || mode == Mode::path || mode == Mode::batch; }

  static Pose pose(const peers::Matrix& m) {
    return Pose(m[0][0], m[0][1], m[0][2], m[0][3], m[1][0], m[1][1], m[1][2], m[1][3], m[2][0], m[2][1], m[2][2], m[2][3]);
  }

  Cgal(const peers::Mesh& a, const peers::Mesh& b) : a_(surface(a)), b_(surface(b)) {
    first_ = scene_.add_mesh(a_);
    second_ = scene_.add_mesh(b_);
  }

  void forget() {}

  double answer(Mode, const Pose& a_from_b) {
    scene_.set_transformation(second_, a_from_b);
    return scene_.get_all_intersections(first_).empty() ? 0 : 1;
  }

  std::size_t bytes() const { return 0; }

 private:
  // A surface with an edge of more than two faces is taken apart there, which changes no point of it.
  static Surface surface(const peers::Mesh& mesh) {
    std::vector<Kernel::Point_3> points;
    std::vector<std::array<std::size_t, 3>> faces;
    for (const auto& v : mesh.vertices) points.emplace_back(v[0], v[1], v[2]);
    for (const auto& f : mesh.faces) faces.push_back({f[0], f[1], f[2]});
    CGAL::Polygon_mesh_processing::orient_polygon_soup(points, faces);
    Surface result;
    CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, faces, result);
    return result;
  }

  Surface a_, b_;
  CGAL::Rigid_triangle_mesh_collision_detection<Surface> scene_;
  std::size_t first_ = 0, second_ = 0;
};

int main(int count, char** words) { return peers::serve<Cgal>(std::vector<std::string>(words + 1, words + count)); }
