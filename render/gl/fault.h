// What can befall a GL context, and how a test makes it happen: software drivers never lose one.
//
//   gl::Worker::Create({.context = {.inject_fault = [&](std::string_view) {
//     return ++checks % 100 == 0 ? gl::Fault::kLost : gl::Fault::kNone;
//   }}});
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "absl/status/status.h"

namespace penumbra::gl {

// Each is worse than those before it.
enum class Fault : uint8_t {
  kNone,
  kOverBudget,   // memory was refused before GL was asked for it (memory_budget.h)
  kOutOfMemory,  // GL had none; what state it is in is undefined from then on
  kError,        // GL refused a command, or a shader: it is not in the state that we think it is in
  kLost,         // the device was reset, or the context could not be made: all objects are gone
};

// Asked at each Context::Check, with what is checked, and when a context is made ("gl::Context", of
// which kLost alone can come); what it returns happens there.
using FaultInjector = std::function<Fault(std::string_view what)>;

// A stable word for clients: "GL_CONTEXT_LOST".
std::string_view ReasonOf(Fault fault);

// An error of the fault's code, which FaultOf recognises:
//
//   kOverBudget, kOutOfMemory → kResourceExhausted;  kError → kInternal;  kLost → kUnavailable
absl::Status FaultError(Fault fault, std::string_view message);

// kNone for any other status.
Fault FaultOf(const absl::Status& status);

}  // namespace penumbra::gl
