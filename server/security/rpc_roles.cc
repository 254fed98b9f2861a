#include "server/security/rpc_roles.h"

#include <algorithm>
#include <string>

#include "render/scene/field_error.h"
#include "render/scene/scene.h"

namespace penumbra {
namespace {

constexpr RpcRole kRoles[] = {
    {"Session", Role::kViewer, SceneRule::kNamed, "the hello names the scene"},
    {"CreateScene", Role::kEditor, SceneRule::kMade, "a scope leaves room for scenes to come"},
    {"ListScenes", Role::kViewer, SceneRule::kListed, ""},
    {"DeleteScene", Role::kEditor, SceneRule::kNamed, "an editor can empty it anyway"},
    {"GetServerInfo", Role::kViewer, SceneRule::kNone,
     "clients need the limits; its counters are over all scenes, so a scope that is not all of "
     "them "
     "hides them"},
    {"GetServerStatus", Role::kAdmin, SceneRule::kListed, "it tells who does what"},
    {"ListTechniques", Role::kViewer, SceneRule::kNone, ""},
    {"FindMissingBlobs", Role::kEditor, SceneRule::kContents, "others' blobs are missing"},
    {"UploadBlob", Role::kEditor, SceneRule::kNone, ""},
    {"DownloadBlob", Role::kViewer, SceneRule::kContents, "others' blobs are not found"},
    {"ExportScene", Role::kEditor, SceneRule::kNamed, "its history tells what was there before"},
    {"ImportScene", Role::kEditor, SceneRule::kMade, ""},
    {"Session.hello", Role::kViewer, SceneRule::kNamed, ""},
    {"Session.commit", Role::kEditor, SceneRule::kNone, "the hello has named the scene"},
    {"Session.subscribe", Role::kViewer, SceneRule::kNone, ""},
    {"Session.unsubscribe", Role::kViewer, SceneRule::kNone, ""},
    {"Session.credit", Role::kViewer, SceneRule::kNone, ""},
    {"Session.acknowledgement", Role::kViewer, SceneRule::kNone, ""},
    {"Session.view_report", Role::kViewer, SceneRule::kNone, ""},
    {"Session.subscribe_each", Role::kViewer, SceneRule::kNone, ""},
    {"Session.presence", Role::kViewer, SceneRule::kNone, ""},
    {"Session.edit_control", Role::kEditor, SceneRule::kNone, ""},
};

// In the words of SceneStore and LocalEngine, which a test compares.
absl::Status NoSuchScene(std::string_view scene_id) {
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                    "found '" + std::string(scene_id) + "', need the id of a scene");
}

}  // namespace

std::span<const RpcRole> RpcRoles() { return kRoles; }

const RpcRole* FindRpcRole(std::string_view name) {
  const auto row = std::find_if(std::begin(kRoles), std::end(kRoles),
                                [&](const RpcRole& role) { return role.name == name; });
  return row == std::end(kRoles) ? nullptr : row;
}

absl::Status Authorize(std::string_view name, const Identity& identity,
                       std::optional<std::string_view> scene_id) {
  const RpcRole* row = FindRpcRole(name);
  if (!row || identity.role < row->least) {
    const std::string need = row ? std::string(RoleName(row->least)) : "a server that allows it";
    return FieldError(absl::StatusCode::kPermissionDenied, "ROLE", "",
                      std::string(name) + ": found role " + std::string(RoleName(identity.role)) +
                          ", need " + need);
  }
  const bool is_by_scene = row->scene == SceneRule::kNamed || row->scene == SceneRule::kMade;
  if (!is_by_scene || !scene_id || identity.scope.Contains(*scene_id)) return absl::OkStatus();
  // An id that no scene can have says nothing of which there are.
  if (auto status = CheckId(*scene_id, "scene_id"); !status.ok()) return status;
  if (row->scene == SceneRule::kNamed) return NoSuchScene(*scene_id);
  return FieldError(absl::StatusCode::kPermissionDenied, "SCOPE", "scene_id",
                    "found '" + std::string(*scene_id) + "', need an id within your scenes");
}

}  // namespace penumbra
