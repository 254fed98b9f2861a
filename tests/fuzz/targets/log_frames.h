// A write-ahead log of SQLite's as frames, to be damaged where it has a structure (section 4 of
// sqlite.org/fileformat2.html).
#pragma once

#include <cstddef>
#include <string>

namespace penumbra::fuzzing {

// Of logs with pages as our journals have them.
inline constexpr size_t kLogHeadBytes = 32;
inline constexpr size_t kFrameHeadBytes = 24;
inline constexpr size_t kFrameBytes = kFrameHeadBytes + 4'096;

// Whole frames.
size_t FrameCount(const std::string& log);

// Exchanges two frames, takes one out, or puts a copy of one behind another.
void SwapFrames(std::string& log, size_t a, size_t b);
void DropFrame(std::string& log, size_t index);
void CopyFrame(std::string& log, size_t from, size_t behind);

// Makes salts and checksums right, as if SQLite had written what is there: what is wrong with it is
// for whoever reads its rows to find.
void SumAnew(std::string& log);

}  // namespace penumbra::fuzzing
