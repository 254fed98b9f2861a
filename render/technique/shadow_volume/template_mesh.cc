#include "render/technique/shadow_volume/template_mesh.h"

#include <array>
#include <bit>

#include "render/artifact/shadow_volume_mesh.h"

namespace penumbra {
namespace {

// Corners of a cell's triangles, of either split, counter-clockwise in (x, y).
constexpr int kTriangleCorners[2][2][3] = {{{0, 1, 2}, {2, 3, 0}}, {{0, 1, 3}, {2, 3, 1}}};
// The cell's sides that they have, as bits.
constexpr int kTriangleSides[2][2] = {{0b0011, 0b1100}, {0b1001, 0b0110}};

constexpr int kDanglingCodes = 1 << 0b0001 | 1 << 0b0010 | 1 << 0b0100 | 1 << 0b1000;

constexpr std::array<std::array<uint8_t, 16>, 2> MakeTable() {
  std::array<std::array<uint8_t, 16>, 2> table{};
  for (int split = 0; split < 2; ++split) {
    for (int code = 0; code < 16; ++code) {
      const bool first = code & kTriangleSides[split][0], second = code & kTriangleSides[split][1];
      const bool ends = kDanglingCodes >> code & 1;
      table[split][code] = static_cast<uint8_t>((first || ends) | (second || ends) << 1);
    }
  }
  return table;
}
constexpr auto kTable = MakeTable();

class Builder {
 public:
  Builder(const VolumeGrid& grid, VolumeTriangles& mesh)
      : grid_(grid), mesh_(mesh), rows_{Unused(), Unused()} {}

  // Cells come row by row.
  void AddCell(uint32_t x, uint32_t y, int triangles, int split) {
    Reach(y);
    for (int k = 0; k < 2; ++k) {
      if (triangles >> k & 1) AddTriangle(x, y, kTriangleCorners[split][k]);
    }
  }

 private:
  static constexpr uint32_t kUnused = ~uint32_t{0};
  std::vector<uint32_t> Unused() const { return std::vector<uint32_t>(grid_.width(), kUnused); }

  // Forgets the vertices of rows before y.
  void Reach(uint32_t y) {
    if (y == row_) return;
    rows_[0] = Unused();
    if (y == row_ + 1)
      std::swap(rows_[0], rows_[1]);
    else
      rows_[1] = Unused();
    row_ = y;
  }

  uint32_t VertexOf(uint32_t x, uint32_t y) {
    uint32_t& vertex = rows_[y - row_][x];
    if (vertex == kUnused) {
      vertex = static_cast<uint32_t>(mesh_.vertices.size());
      mesh_.vertices.emplace_back(grid_.WorldAt(x, y));
    }
    return vertex;
  }

  void AddTriangle(uint32_t x, uint32_t y, const int (&corners)[3]) {
    std::array<GridCorner, 3> at;
    int seeing = 0;
    for (int k = 0; k < 3; ++k) {
      at[k] = {x + (corners[k] == 1 || corners[k] == 2), y + (corners[k] >= 2)};
      seeing += grid_.At(at[k].x, at[k].y) != grid_.nothing();
    }
    // Infinitely far two corners are one place where rays are parallel.
    if (seeing < (grid_.from_infinity() ? 2 : 1)) return;
    mesh_.is_cut_off = mesh_.is_cut_off || mesh_.indices.size() >= 3 * kMaxVolumeTriangles ||
                       mesh_.vertices.size() + 3 > kMaxVolumeVertices;
    if (mesh_.is_cut_off) return;
    if (!grid_.is_right_handed()) std::swap(at[1], at[2]);
    for (const GridCorner& corner : at) mesh_.indices.push_back(VertexOf(corner.x, corner.y));
  }

  const VolumeGrid& grid_;
  VolumeTriangles& mesh_;
  uint32_t row_ = 0;
  std::array<std::vector<uint32_t>, 2> rows_;  // vertices of the samples of rows row_, row_ + 1
};

}  // namespace

int TemplateTriangles(int code, int split) { return kTable[split][code]; }

void AddTriangles(const VolumeGrid& grid, const EdgeMap& edges, Reconstruction reconstruction,
                  VolumeTriangles& mesh) {
  Builder builder(grid, mesh);
  if (reconstruction == Reconstruction::kAllCells) {
    for (uint32_t y = grid.first_cell(); grid.has_cells() && y < grid.end_cell_y(); ++y) {
      for (uint32_t x = grid.first_cell(); x < grid.end_cell_x(); ++x) {
        builder.AddCell(x, y, 0b11, grid.SplitsAtOneThree(x, y));
      }
    }
    return;
  }
  edges.ForEachCell([&](uint32_t x, uint32_t y, int code) {
    const int split = grid.SplitsAtOneThree(x, y);
    const bool whole = reconstruction == Reconstruction::kFixedMesh;
    builder.AddCell(x, y, whole ? 0b11 : TemplateTriangles(code, split), split);
  });
}

}  // namespace penumbra
