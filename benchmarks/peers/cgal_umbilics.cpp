// Umbilics as CGAL finds them (Cazals & Pouget, packages Jet_fitting_3 and Ridges_3).
//
// Reads from standard input the numbers of vertices and triangles, the positions and the
// corners; writes a line "vertex index" for each umbilic: index 1 or -1 in units of one half,
// 0 where CGAL calls it non-generic. Jets of degree 3, neighbourhood size 2.
//
// With two arguments, a file and a number of rounds, everything is done that often; the file gets
// the number of rounds, for each one the seconds for the jets and for the umbilics, kB of memory
// after reading and at most, in one line, and then, 3 doubles a vertex, the directions in which a
// convex surface bends most: CGAL's curvatures are negative there, so these are its minimal ones.

#include <CGAL/Monge_via_jet_fitting.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Umbilics.h>

#include <chrono>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <unordered_set>
#include <vector>

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Vertex = Mesh::Vertex_index;
using Fitting = CGAL::Monge_via_jet_fitting<Kernel>;

constexpr std::size_t degree = 3;
constexpr std::size_t coefficients = (degree + 1) * (degree + 2) / 2;
constexpr double size = 2.0;

// The vertex first, then whole rings until there are as many points as coefficients.
static std::vector<Point> neighbourhood(const Mesh& mesh, Vertex centre) {
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
    return points;
}

static double now() {
    using namespace std::chrono;
    return duration<double>(steady_clock::now().time_since_epoch()).count();
}

// Memory of this process in kB, "VmRSS:" now or "VmHWM:" at most; 0 where there is no /proc.
static long memory(const std::string& which) {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == which) {
            long size = 0;
            status >> size;
            return size;
        }
    return 0;
}

int main(int argc, char** argv) {
    std::ios::sync_with_stdio(false);
    std::size_t vertices = 0, triangles = 0;
    if (!(std::cin >> vertices >> triangles)) {
        std::cerr << "no mesh on standard input\n";
        return 1;
    }
    Mesh mesh;
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
            return 1;
        }
    }

    const long memory_before = memory("VmRSS:");
    const int rounds = argc > 2 ? std::stoi(argv[2]) : 1;
    auto k1 = mesh.add_property_map<Vertex, double>("v:k1", 0.0).first;
    auto k2 = mesh.add_property_map<Vertex, double>("v:k2", 0.0).first;
    auto d1 = mesh.add_property_map<Vertex, Vector>("v:d1", Vector(1, 0, 0)).first;
    auto d2 = mesh.add_property_map<Vertex, Vector>("v:d2", Vector(0, 1, 0)).first;
    std::vector<double> seconds;
    std::vector<CGAL::Umbilic<Mesh>*> umbilics;
    for (int round = 0; round < rounds; ++round) {
        for (const CGAL::Umbilic<Mesh>* umbilic : umbilics) delete umbilic;
        umbilics.clear();
        const double start = now();
        for (Vertex vertex : mesh.vertices()) {
            const std::vector<Point> points = neighbourhood(mesh, vertex);
            if (points.size() < coefficients) continue;
            Fitting fitting;
            auto monge = fitting(points.begin(), points.end(), degree, degree);
            monge.comply_wrt_given_normal(
                CGAL::Polygon_mesh_processing::compute_vertex_normal(vertex, mesh));
            k1[vertex] = monge.principal_curvatures(0);
            k2[vertex] = monge.principal_curvatures(1);
            d1[vertex] = monge.maximal_principal_direction();
            d2[vertex] = monge.minimal_principal_direction();
        }
        const double fitted = now();
        CGAL::compute_umbilics(mesh, k1, k2, d1, d2, std::back_inserter(umbilics), size);
        seconds.push_back(fitted - start);
        seconds.push_back(now() - fitted);
    }
    if (argc > 2) {
        std::ofstream measured(argv[1], std::ios::binary);
        measured << rounds;
        for (double value : seconds) measured << ' ' << value;
        measured << ' ' << memory_before << ' ' << memory("VmHWM:") << '\n';
        for (Vertex vertex : mesh.vertices()) {
            const double direction[3] = {d2[vertex].x(), d2[vertex].y(), d2[vertex].z()};
            measured.write(reinterpret_cast<const char*>(direction), sizeof direction);
        }
    }
    for (const CGAL::Umbilic<Mesh>* umbilic : umbilics) {
        int index = 0;
        if (umbilic->umbilic_type() == CGAL::ELLIPTIC_UMBILIC) index = 1;
        if (umbilic->umbilic_type() == CGAL::HYPERBOLIC_UMBILIC) index = -1;
        std::cout << umbilic->vertex().idx() << ' ' << index << '\n';
        delete umbilic;
    }
}
