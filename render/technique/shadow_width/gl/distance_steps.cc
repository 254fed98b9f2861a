#include "render/technique/shadow_width/gl/distance_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/gl/draw.h"
#include "render/gl/framebuffer.h"
#include "render/gl/program.h"
#include "render/gl/readback.h"
#include "render/gl/texture.h"
#include "render/gl/vertex_array.h"
#include "render/gl/work_pace.h"
#include "render/technique/shadow_width/gl/distance_steps_glsl.h"

namespace penumbra {
namespace {

int CountOf(StepNeighbours neighbours) { return neighbours == StepNeighbours::kThree ? 3 : 6; }

// Halves towards 0. The sines of the directions' halves come out of rounding either way.
int Rounded(double value) {
  constexpr double kRounding = 1e-9;
  return static_cast<int>(std::copysign(std::ceil(std::abs(value) - 0.5 - kRounding), value));
}

// Kept with the context.
class Stepper {
 public:
  static absl::StatusOr<Stepper*> Of(gl::Context& context) {
    static constexpr char kOwner = 0;
    std::shared_ptr<void>& kept = context.Kept(&kOwner);
    if (!kept) {
      auto stepper = std::make_shared<Stepper>();
      if (absl::Status status = stepper->Create(context); !status.ok()) return status;
      kept = std::move(stepper);
    }
    return static_cast<Stepper*>(kept.get());
  }

  absl::Status Start(gl::Context& context, const gl::Texture& blocked, gl::Framebuffer& target,
                     const std::stop_token& stop) {
    pace_.Start(context);
    blocked.Bind(context, width_gl::kSourceUnit);
    return Fill(context, start_, target, stop);
  }

  absl::Status Step(gl::Context& context, StepNeighbours neighbours, int size,
                    const gl::Framebuffer& source, gl::Framebuffer& target,
                    const std::stop_token& stop) {
    gl::Program& program = neighbours == StepNeighbours::kThree ? three_ : six_;
    const std::vector<DistanceStep> steps = StepsOf(neighbours, size);
    for (size_t i = 0; i < steps.size(); ++i) {
      program.Set(context, absl::StrCat("offsets[", i, "]").c_str(), steps[i].offset);
      program.Set(context, absl::StrCat("lengths[", i, "]").c_str(), steps[i].length);
    }
    source.BindColor(context, width_gl::kSourceUnit);
    return Fill(context, program, target, stop);
  }

 private:
  absl::Status Create(gl::Context& context) {
    auto vertices = gl::VertexArray::Create(context);
    if (!vertices.ok()) return vertices.status();
    no_attributes_ = *std::move(vertices);
    const std::pair<gl::Program*, gl::ProgramSource> programs[] = {
        {&start_, width_gl::StartProgram()},
        {&three_, width_gl::StepProgram(CountOf(StepNeighbours::kThree))},
        {&six_, width_gl::StepProgram(CountOf(StepNeighbours::kSix))}};
    for (const auto& [program, source] : programs) {
      auto made = gl::Program::Create(context, source);
      if (!made.ok()) return made.status();
      *program = *std::move(made);
    }
    return absl::OkStatus();
  }

  // Rows at a time, whose texels are the units of work.
  absl::Status Fill(gl::Context& context, const gl::Program& program, gl::Framebuffer& target,
                    const std::stop_token& stop) {
    const int width = target.options().width, height = target.options().height;
    gl::PixelArea band{.width = width};
    for (; band.y < height; band.y += band.height) {
      band.height =
          static_cast<int>(std::clamp(pace_.most() / width, 1.0, 1.0 * (height - band.y)));
      gl::Draw(context, {.program = program,
                         .vertices = no_attributes_,
                         .target = target,
                         .count = 3,
                         .depth_test = gl::DepthTest::kNone,
                         .writes_depth = false,
                         .area = band});
      const double texels = 1.0 * width * band.height;
      if (auto status = pace_.Did(context, texels, stop); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  gl::VertexArray no_attributes_;
  gl::Program start_, three_, six_;
  gl::WorkPace pace_;
};

}  // namespace

std::vector<DistanceStep> StepsOf(StepNeighbours neighbours, int size) {
  const int count = CountOf(neighbours);
  std::vector<DistanceStep> steps;
  for (int i = 0; i < count; ++i) {
    const double angle = std::numbers::pi * (0.5 + 2.0 * i / count);
    const glm::ivec2 offset(Rounded(size * std::cos(angle)), Rounded(size * std::sin(angle)));
    steps.push_back({offset, static_cast<float>(std::hypot(offset.x, offset.y))});
  }
  return steps;
}

absl::StatusOr<std::vector<float>> DistanceBySteps(gl::Context& context, const BlockedMask& mask,
                                                   StepNeighbours neighbours,
                                                   const std::stop_token& stop) {
  if (absl::Status status = CheckMask(mask); !status.ok()) return status;
  if (absl::Status status = context.Check("DistanceBySteps"); !status.ok()) return status;
  const auto stepper = Stepper::Of(context);
  if (!stepper.ok()) return stepper.status();
  const int width = static_cast<int>(mask.width), height = static_cast<int>(mask.height);
  auto blocked =
      gl::Texture::Create(context, {.width = width, .height = height, .format = gl::Format::kR8Ui});
  if (!blocked.ok()) return blocked.status();
  absl::Status written = blocked->Write(context, std::as_bytes(mask.blocked));
  if (!written.ok()) return written;
  const gl::FramebufferOptions options{
      .width = width, .height = height, .color = gl::Format::kR32F, .has_depth = false};
  auto source = gl::Framebuffer::Create(context, options);
  auto target = gl::Framebuffer::Create(context, options);
  if (!source.ok()) return source.status();
  if (!target.ok()) return target.status();
  absl::Status filled = (*stepper)->Start(context, *blocked, *source, stop);
  for (int size = 1; filled.ok() && size < std::max(width, height); size *= 2) {
    filled = (*stepper)->Step(context, neighbours, size, *source, *target, stop);
    std::swap(source, target);
  }
  if (!filled.ok()) return filled;
  auto readback = gl::Readback::Start(context, *source, {0, 0, width, height}, 1);
  if (!readback.ok()) return readback.status();
  auto distances = readback->Wait(context);
  if (!distances.ok()) return distances.status();
  if (stop.stop_requested()) return absl::CancelledError("stop requested");
  std::ranges::replace(*distances, width_gl::kNowhere, std::numeric_limits<float>::infinity());
  return distances;
}

}  // namespace penumbra
