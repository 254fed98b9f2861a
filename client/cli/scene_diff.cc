#include "client/cli/scene_diff.h"

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "client/session/scene_json.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;
using Fields = std::map<std::string, std::string>;
using Objects = std::map<std::string, Fields>;

std::string TextOf(const std::string& field, const Json& value) {
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  std::string hash;
  // Bytes are Base64 in JSON; hashes are read as hexadecimal everywhere else.
  if (!field.ends_with("_hash") || !absl::Base64Unescape(text, &hash)) return text;
  return absl::BytesToHexString(hash);
}

bool IsVector(const Json& value) {
  return value.is_object() && value.size() == 3 && value.contains("x") && value.contains("y") &&
         value.contains("z");
}

void Flatten(const Json& object, const std::string& path, Fields& fields) {
  for (const auto& [name, value] : object.items()) {
    const std::string field = path.empty() ? name : absl::StrCat(path, ".", name);
    if (IsVector(value)) {
      fields[field] =
          absl::StrCat("(", value["x"].dump(), " ", value["y"].dump(), " ", value["z"].dump(), ")");
    } else if (value.is_object()) {
      Flatten(value, field, fields);
    } else if (field != "id") {
      fields[field] = TextOf(field, value);
    }
  }
}

Objects ObjectsOf(const Json& scene, const char* list) {
  Objects objects;
  for (const Json& object : scene.value(list, Json::array())) {
    Flatten(object, "", objects[object.value("id", "")]);
  }
  return objects;
}

std::vector<FieldChange> DiffFields(const Fields& from, const Fields& to) {
  std::vector<FieldChange> changes;
  for (const auto& [field, text] : from) {
    const auto other = to.find(field);
    const std::string now = other == to.end() ? "" : other->second;
    if (now != text) changes.push_back({.field = field, .from = text, .to = now});
  }
  for (const auto& [field, text] : to) {
    if (!from.contains(field)) changes.push_back({.field = field, .from = "", .to = text});
  }
  return changes;
}

void DiffObjects(const std::string& object, const Objects& from, const Objects& to,
                 std::vector<ObjectChange>& changes) {
  Objects all = from;
  all.insert(to.begin(), to.end());
  for (const auto& [id, ignored] : all) {
    const auto before = from.find(id), after = to.find(id);
    ObjectChange change{.object = object, .id = id};
    if (before == from.end()) {
      change.kind = ObjectChange::Kind::kAdded;
    } else if (after == to.end()) {
      change.kind = ObjectChange::Kind::kRemoved;
    } else {
      change.fields = DiffFields(before->second, after->second);
      if (change.fields.empty()) continue;
    }
    changes.push_back(std::move(change));
  }
}

}  // namespace

std::vector<ObjectChange> DiffScenes(const Scene& from, const Scene& to) {
  std::vector<ObjectChange> changes;
  if (from.content_hash() == to.content_hash()) return changes;
  const Json before = Json::parse(SceneJson(from), nullptr, /*allow_exceptions=*/false);
  const Json after = Json::parse(SceneJson(to), nullptr, /*allow_exceptions=*/false);
  for (const auto& [object, list] :
       {std::pair("instance", "upsert_instances"), std::pair("light", "upsert_lights"),
        std::pair("receiver", "upsert_receivers")}) {
    DiffObjects(object, ObjectsOf(before, list), ObjectsOf(after, list), changes);
  }
  return changes;
}

}  // namespace penumbra
