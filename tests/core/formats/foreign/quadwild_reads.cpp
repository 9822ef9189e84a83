// QuadWild's own mesh class reads a mesh, its .rosy field and its .sharp features, and prints what
// it understood: the directions of the faces, the singular vertices of the field, the marked edges.
#include <mesh_types.h>

#include <cstdio>

int main(int, char **argv)
{
    TriangleMesh mesh;
    std::string features = argv[3];
    if (!mesh.LoadMesh(argv[1])) return 1;
    mesh.UpdateAttributes();
    if (!mesh.LoadField(argv[2])) return 2;
    if (!mesh.LoadSharpFeatures(features)) return 3;
    std::printf("faces %d\n", mesh.fn);
    for (auto &face : mesh.face)
        std::printf("direction %.9g %.9g %.9g\n", face.PD1()[0], face.PD1()[1], face.PD1()[2]);
    auto singular = vcg::tri::Allocator<TriangleMesh>::GetPerVertexAttribute<bool>(
        mesh, std::string("Singular"));
    for (size_t i = 0; i < mesh.vert.size(); i++)
        if (singular[i]) std::printf("singular %zu\n", i);
    for (size_t i = 0; i < mesh.face.size(); i++)
        for (int side = 0; side < 3; side++)
            if (mesh.face[i].IsFaceEdgeS(side)) std::printf("sharp %zu %d\n", i, side);
}
