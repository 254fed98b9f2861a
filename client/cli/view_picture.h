// The shadows that a view needs, and the picture that comes of them.
//
//   Shadows shadows;
//   ReceiveShadows(engine, scene_id, WantedShadows(command, plan, camera), room, console, stop,
//                  shadows);
//   DrawView(command, pencil, camera, scene, shadows, console);
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/commands.h"
#include "client/cli/console.h"
#include "client/cli/draw_scene.h"
#include "client/cli/shadow_plan.h"
#include "render/engine/engine.h"

namespace penumbra {

// In the order in which they are computed: those of any view, the final picture's.
std::vector<PlannedShadow> WantedShadows(const ViewCommand& command, const ShadowPlan& plan,
                                         const Camera& camera);

// Appends to `shadows`.
//
// Errors  those of CheckWidthsFit and ComputeShadow
absl::Status ReceiveShadows(Engine& engine, const std::string& scene_id,
                            const std::vector<PlannedShadow>& wanted, const DrawRoom& room,
                            const Console& console, const std::stop_token& stop, Shadows& shadows);

// Draws the picture, writes it, and says so. Of a watched scene the file is replaced as a whole,
// for those who look at it meanwhile.
//
// Errors  those of Pencil::Draw; kUnavailable: the file cannot be replaced
absl::Status DrawView(const ViewCommand& command, Pencil& pencil, const Camera& camera,
                      const Scene& scene, const Shadows& shadows, const Console& console);

}  // namespace penumbra
