// Directional reads a mesh, its .rawfield and its .sing, finds the singularities of the field by
// its own principal matching, and prints both.
#include <directional/CartesianField.h>
#include <directional/PCFaceTangentBundle.h>
#include <directional/TriMesh.h>
#include <directional/principal_matching.h>
#include <directional/readOBJ.h>
#include <directional/read_raw_field.h>
#include <directional/read_singularities.h>

#include <cstdio>

int main(int, char **argv)
{
    directional::TriMesh mesh;
    directional::PCFaceTangentBundle bundle;
    directional::CartesianField field;
    int degree = 0, singular_degree = 0;
    if (!directional::readOBJ(argv[1], mesh)) return 1;
    bundle.init(mesh);
    if (!directional::read_raw_field(argv[2], bundle, degree, field)) return 2;
    Eigen::VectorXi element, index;
    // Its answer is whether reading failed.
    if (directional::read_singularities(argv[3], singular_degree, element, index)) return 3;
    std::printf("degree %d %d\n", degree, singular_degree);
    for (int i = 0; i < field.extField.rows(); i++)
    {
        std::printf("vectors");
        for (int j = 0; j < field.extField.cols(); j++) std::printf(" %.17g", field.extField(i, j));
        std::printf("\n");
    }
    for (int i = 0; i < element.size(); i++) std::printf("read %d %d\n", element[i], index[i]);
    directional::principal_matching(field);
    for (int i = 0; i < field.singLocalCycles.size(); i++)
        std::printf("found %d %d\n", field.singLocalCycles[i], field.singIndices[i]);
}
