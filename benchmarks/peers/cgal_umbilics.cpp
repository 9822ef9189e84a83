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

#include "cgal_jets.h"

#include <CGAL/Umbilics.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <string>

constexpr std::size_t degree = 3;
constexpr double size = 2.0;

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
    Mesh mesh;
    if (!read(mesh)) return 1;

    const long memory_before = memory("VmRSS:");
    const int rounds = argc > 2 ? std::stoi(argv[2]) : 1;
    Principal principal(mesh);
    std::vector<double> seconds;
    std::vector<CGAL::Umbilic<Mesh>*> umbilics;
    for (int round = 0; round < rounds; ++round) {
        for (const CGAL::Umbilic<Mesh>* umbilic : umbilics) delete umbilic;
        umbilics.clear();
        const double start = now();
        for (Vertex vertex : mesh.vertices()) {
            const std::optional<Monge> monge = jet(mesh, vertex, degree);
            if (monge) principal.take(vertex, *monge);
        }
        const double fitted = now();
        auto& [k1, k2, d1, d2] = principal;
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
            const Vector& d2 = principal.d2[vertex];
            const double direction[3] = {d2.x(), d2.y(), d2.z()};
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
