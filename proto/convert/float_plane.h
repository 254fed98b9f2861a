// Floats that change little from one to the next, such as depths, as bytes that pack well.
//
//   ToPlane(depths, plane);
//   codec = packer.Pack(plane, packed);
#pragma once

#include <span>
#include <vector>

namespace penumbra {

// The difference of each one's bits to those of the one before, modulo 2^32: of all of them first
// the lowest bytes, then the second, third and highest, most of which are 0.
void ToPlane(std::span<const float> floats, std::vector<char>& plane);

// The other way. The plane has four bytes a float.
void FromPlane(std::span<const char> plane, std::vector<float>& floats);

}  // namespace penumbra
