// Crest lines as CGAL finds them (Cazals & Pouget, packages Jet_fitting_3 and Ridges_3).
//
// Reads from standard input the numbers of vertices and triangles, the positions and the corners;
// writes a line "number x y z" for every point of every crest line. Jets of degree 4 over whole
// rings of at least as many points as it has coefficients, ridges tagged by the fourth order.

#include "cgal_jets.h"

#include <CGAL/Ridges.h>

#include <iomanip>
#include <iterator>

using Ridges = CGAL::Ridge_approximation<Mesh, Numbers, Vectors>;

constexpr std::size_t degree = 4;

int main() {
    Mesh mesh;
    if (!read(mesh)) return 1;
    Principal principal(mesh);
    Numbers b0 = numbers(mesh, "v:b0"), b3 = numbers(mesh, "v:b3");
    Numbers p1 = numbers(mesh, "v:p1"), p2 = numbers(mesh, "v:p2");
    auto& [k1, k2, d1, d2] = principal;
    for (Vertex vertex : mesh.vertices()) {
        const std::optional<Monge> monge = jet(mesh, vertex, degree);
        if (!monge) continue;
        principal.take(vertex, *monge);
        b0[vertex] = monge->third_order_coefficients(0);
        b3[vertex] = monge->third_order_coefficients(3);
        const double gap = k1[vertex] - k2[vertex];
        const double b1 = monge->third_order_coefficients(1);
        const double b2 = monge->third_order_coefficients(2);
        const double c0 = monge->fourth_order_coefficients(0);
        const double c4 = monge->fourth_order_coefficients(4);
        p1[vertex] = 3 * b1 * b1 + gap * (c0 - 3 * k1[vertex] * k1[vertex] * k1[vertex]);
        p2[vertex] = 3 * b2 * b2 - gap * (c4 - 3 * k2[vertex] * k2[vertex] * k2[vertex]);
    }
    Ridges ridges(mesh, k1, k2, b0, b3, d1, d2, p1, p2);
    std::vector<Ridges::Ridge_line*> lines;
    ridges.compute_crest_ridges(std::back_inserter(lines), CGAL::Ridge_order_4);
    std::cout << std::setprecision(17);
    std::size_t number = 0;
    for (const Ridges::Ridge_line* line : lines) {
        for (const auto& [halfedge, share] : *line->line()) {
            const Point& p = mesh.point(mesh.source(halfedge));
            const Point& q = mesh.point(mesh.target(halfedge));
            const Point point = CGAL::barycenter(p, share, q);
            std::cout << number << ' ' << point.x() << ' ' << point.y() << ' ' << point.z() << '\n';
        }
        ++number;
        delete line;
    }
}
