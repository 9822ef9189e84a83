// What both drivers of CGAL begin with: the mesh, and the points that a jet is fitted to.

#pragma once

#include <CGAL/Monge_via_jet_fitting.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <cstddef>
#include <iostream>
#include <optional>
#include <unordered_set>
#include <vector>

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Vertex = Mesh::Vertex_index;
using Fitting = CGAL::Monge_via_jet_fitting<Kernel>;
using Monge = Fitting::Monge_form;

// Standard input: the numbers of vertices and triangles, the positions and the corners. False, with
// the reason on standard error, where that is no manifold mesh.
inline bool read(Mesh& mesh) {
    std::ios::sync_with_stdio(false);
    std::size_t vertices = 0, triangles = 0;
    if (!(std::cin >> vertices >> triangles)) {
        std::cerr << "no mesh on standard input\n";
        return false;
    }
    for (std::size_t i = 0; i < vertices; ++i) {
        double x, y, z;
        std::cin >> x >> y >> z;
        mesh.add_vertex(Point(x, y, z));
    }
    for (std::size_t i = 0; i < triangles; ++i) {
        std::size_t a, b, c;
        std::cin >> a >> b >> c;
        if (mesh.add_face(Vertex(a), Vertex(b), Vertex(c)) == Mesh::null_face()) {
            std::cerr << "triangle " << i << " does not fit a manifold\n";
            return false;
        }
    }
    return true;
}

// The jet of this degree over the vertex first, then whole rings until there are as many points as
// it has coefficients; none where the surface has too few.
inline std::optional<Monge> jet(const Mesh& mesh, Vertex centre, std::size_t degree) {
    const std::size_t coefficients = (degree + 1) * (degree + 2) / 2;
    std::vector<Point> points{mesh.point(centre)};
    std::vector<Vertex> ring{centre};
    std::unordered_set<std::size_t> seen{centre.idx()};
    while (points.size() < coefficients && !ring.empty()) {
        std::vector<Vertex> next;
        for (Vertex vertex : ring)
            for (Vertex neighbour : CGAL::vertices_around_target(mesh.halfedge(vertex), mesh))
                if (seen.insert(neighbour.idx()).second) {
                    next.push_back(neighbour);
                    points.push_back(mesh.point(neighbour));
                }
        ring = std::move(next);
    }
    if (points.size() < coefficients) return std::nullopt;
    Fitting fitting;
    Monge monge = fitting(points.begin(), points.end(), degree, degree);
    monge.comply_wrt_given_normal(
        CGAL::Polygon_mesh_processing::compute_vertex_normal(centre, mesh));
    return monge;
}

using Numbers = Mesh::Property_map<Vertex, double>;
using Vectors = Mesh::Property_map<Vertex, Vector>;

// A number at every vertex, 0 at first.
inline Numbers numbers(Mesh& mesh, const char* name) {
    return mesh.add_property_map<Vertex, double>(name, 0.0).first;
}

// The principal curvatures and directions at every vertex; where no jet was fitted 0, x and y.
struct Principal {
    Numbers k1, k2;
    Vectors d1, d2;

    explicit Principal(Mesh& mesh)
        : k1(numbers(mesh, "v:k1")),
          k2(numbers(mesh, "v:k2")),
          d1(mesh.add_property_map<Vertex, Vector>("v:d1", Vector(1, 0, 0)).first),
          d2(mesh.add_property_map<Vertex, Vector>("v:d2", Vector(0, 1, 0)).first) {}

    void take(Vertex vertex, const Monge& monge) {
        k1[vertex] = monge.principal_curvatures(0);
        k2[vertex] = monge.principal_curvatures(1);
        d1[vertex] = monge.maximal_principal_direction();
        d2[vertex] = monge.minimal_principal_direction();
    }
};
