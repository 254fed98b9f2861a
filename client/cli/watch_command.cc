// penumbra watch: prints each update of a server's scene.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/fitting_options.h"
#include "client/cli/open_engine.h"
#include "client/cli/option_error.h"
#include "client/cli/run_command.h"
#include "client/session/remote_engine.h"
#include "client/session/steady_clock.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

// What is printed, from the callbacks' threads, and when it has been enough.
class UpdatePrinter {
 public:
  // `shadow_count`: how many are watched.
  UpdatePrinter(const WatchCommand& command, size_t shadow_count, const Console& console)
      : command_(command), shadow_count_(shadow_count), console_(console), start_ms_(NowMs()) {}

  void Print(const ArtifactSpec& spec, const ArtifactUpdate& update, const UpdateTraffic& traffic);
  // Waits until nothing more is to be printed.
  absl::Status Wait(std::stop_token stop);

 private:
  bool IsEnough() const {
    return !ended_.ok() || (command_.max_updates > 0 && count_ >= command_.max_updates) ||
           (command_.until_final && final_.size() + refused_.size() >= shadow_count_);
  }
  void Note(const std::string& shadow, const ArtifactUpdate& update);
  bool TakeFirst(const std::string& shadow, const Artifact& artifact);
  std::string Line(const ArtifactSpec& spec, const ArtifactUpdate& update,
                   const UpdateTraffic& traffic, bool comes_first) const;

  const WatchCommand& command_;
  const size_t shadow_count_;
  const Console& console_;
  const double start_ms_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  uint64_t count_ = 0;
  std::set<std::string> final_;                  // keys of the shadows that were final once
  std::map<std::string, absl::Status> refused_;  // of others, for good
  std::map<std::string, Revision> newest_;       // computed, of each shadow, by key
  absl::Status ended_;
};

// Whether only another request can help: not time, and not somebody's edit that makes an object or
// an OpenGL device of what was missing.
bool IsRefusal(const absl::Status& status) {
  return absl::IsInvalidArgument(status) ||
         (absl::IsResourceExhausted(status) && ErrorReason(status).starts_with("QUOTA_"));
}

// Whether it is the first of a revision that is heard of the shadow, whichever pass that is.
bool UpdatePrinter::TakeFirst(const std::string& shadow, const Artifact& artifact) {
  const Revision computed = artifact.header.revision;
  const auto [newest, is_new] = newest_.try_emplace(shadow, computed);
  return is_new || std::exchange(newest->second, computed) != computed;
}

// A time budget is for what comes first.
std::string UpdatePrinter::Line(const ArtifactSpec& spec, const ArtifactUpdate& update,
                                const UpdateTraffic& traffic, bool comes_first) const {
  const double latency_ms = traffic.received_ms - traffic.since_ms;
  const bool has_budget = command_.time_budget_ms > 0;
  const bool is_late = comes_first && has_budget && latency_ms > command_.time_budget_ms;
  const double at_s = 1e-3 * (traffic.received_ms - start_ms_);
  const ArtifactHeader* header = update.artifact ? &update.artifact->header : nullptr;
  if (command_.json) {
    Json json = {{"at_s", at_s},
                 {"revision", update.revision},
                 {"light", spec.light_id},
                 {"receiver", spec.receiver_id},
                 {"bytes", traffic.bytes},
                 {"messages", traffic.messages},
                 {"latency_ms", latency_ms}};
    if (header != nullptr) {
      json["pass"] = header->pass;
      json["is_final"] = header->is_final;
      json["computed_revision"] = header->revision;
      json["samples"] = header->light_samples.size();
      json["timings_ms"] = header->timings_ms;
      if (has_budget) json["is_late"] = is_late;
    } else {
      json["error"] = std::string(update.status.message());
    }
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  const std::string what =
      header == nullptr
          ? OneLine(std::string(update.status.message()))
          : absl::StrFormat("pass %d%s, %d samples", header->pass,
                            header->is_final ? " (final)" : "", header->light_samples.size());
  return absl::StrFormat("%8.3f s  revision %d  %s.%s  %s, %d bytes, latency %.2f ms", at_s,
                         update.revision, spec.receiver_id, spec.light_id, what, traffic.bytes,
                         latency_ms) +
         (is_late ? ", later than asked for" : "");
}

void UpdatePrinter::Print(const ArtifactSpec& spec, const ArtifactUpdate& update,
                          const UpdateTraffic& traffic) {
  std::lock_guard lock(mutex_);
  if (traffic.is_last) ended_.Update(update.status);
  if (IsEnough()) {
    changed_.notify_all();
    return;
  }
  const std::string shadow = SpecKey(spec);
  const bool comes_first = update.artifact && TakeFirst(shadow, *update.artifact);
  console_.out << Line(spec, update, traffic, comes_first) << std::endl;
  ++count_;
  Note(shadow, update);
  changed_.notify_all();
}

void UpdatePrinter::Note(const std::string& shadow, const ArtifactUpdate& update) {
  if (update.artifact) refused_.erase(shadow);
  if (update.artifact && update.artifact->header.is_final) final_.insert(shadow);
  if (IsRefusal(update.status) && !final_.contains(shadow)) refused_[shadow] = update.status;
}

absl::Status UpdatePrinter::Wait(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  const auto is_enough = [this] { return IsEnough(); };
  if (command_.max_seconds > 0.0) {
    const std::chrono::duration<double> longest(std::min(command_.max_seconds, 1e8));
    const bool was_enough = changed_.wait_for(lock, stop, longest, is_enough);
    if (!was_enough && command_.until_final && !stop.stop_requested()) {
      return absl::DeadlineExceededError(
          absl::StrFormat("found %d of %d shadows with all their samples after %g s, need all",
                          final_.size(), shadow_count_, command_.max_seconds));
    }
  } else {
    changed_.wait(lock, stop, is_enough);
  }
  const bool is_refused = command_.until_final && ended_.ok() && !refused_.empty();
  if (is_refused && IsEnough()) return refused_.begin()->second;
  return ended_;
}

// That it is given up is what the command ends with.
void NoteConnection(const ConnectionEvent& event, const Console& console) {
  if (event.kind == ConnectionEvent::Kind::kLost) {
    console.Note("the connection is lost; what is shown is how it was");
  } else if (event.kind == ConnectionEvent::Kind::kRestored) {
    console.Note("the connection is back");
  }
}

template <typename T>
std::vector<std::string> IdsOf(const Scene::Table<T>& table) {
  std::vector<std::string> ids;
  for (const auto& [id, object] : table) ids.push_back(id);
  return ids;
}

// Those named, each once, or all of the table's.
template <typename T>
absl::StatusOr<std::vector<std::string>> Chosen(std::string_view option,
                                                std::vector<std::string> named,
                                                const Scene::Table<T>& table) {
  if (named.empty()) return IdsOf(table);
  std::ranges::sort(named);
  named.erase(std::unique(named.begin(), named.end()), named.end());
  for (const std::string& id : named) {
    const bool is_all = std::is_same_v<T, AreaLight> && id == kAllLights;
    if (!is_all && table.find(id) == table.end()) return UnknownIdError(option, id, IdsOf(table));
  }
  return named;
}

// What the technique computes for: the scene's receivers, or something else.
absl::StatusOr<std::vector<std::string>> ReceiversFor(const WatchCommand& command,
                                                      const Scene& scene) {
  const SpecTarget target = InfoOf(command.params).target;
  if (target == SpecTarget::kReceiver) {
    return Chosen("--receiver", command.receiver_ids, scene.receivers());
  }
  if (!command.receiver_ids.empty()) {
    return TechniqueConflict("--receiver", command.params, "soft_texture");
  }
  if (target == SpecTarget::kPoints && !command.camera) {
    return OptionError("--technique", "MISSING_OPTION", {InfoOf(command.params).name},
                       " without --camera, need what picture to compute");
  }
  return std::vector<std::string>{""};
}

ArtifactSpec SpecOf(const WatchCommand& command, const std::string& light_id,
                    const std::string& receiver_id) {
  ArtifactSpec spec{command.params, light_id, receiver_id, command.time_budget_ms};
  if (InfoOf(command.params).target == SpecTarget::kPoints) {
    const GridSize size = command.picture.value_or(kPictureSize);
    spec.points =
        PicturePixels{.camera = *command.camera, .width = size.width, .height = size.height};
  }
  return spec;
}

absl::Status CheckOptionsFit(const WatchCommand& command) {
  if (command.picture && InfoOf(command.params).target != SpecTarget::kPoints) {
    return TechniqueConflict("--picture", command.params, "coherent_raytrace");
  }
  return CheckLightsFit(command.light_ids, command.params);
}

}  // namespace

absl::Status Run(const WatchCommand& command, const Console& console, std::stop_token stop) {
  if (const auto status = CheckOptionsFit(command); !status.ok()) return status;
  const auto engine =
      ConnectTo(command.engine, nullptr, &console,
                [&console](const ConnectionEvent& event) { NoteConnection(event, console); });
  if (!engine.ok()) return engine.status();
  const auto scene = SceneOf(**engine, command.scene_id);
  if (!scene.ok()) return scene.status();
  const auto lights = Chosen("--light", command.light_ids, (*scene)->lights());
  if (!lights.ok()) return lights.status();
  const auto receivers = ReceiversFor(command, **scene);
  if (!receivers.ok()) return receivers.status();
  if (lights->empty() || receivers->empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "scene ", command.scene_id, ": found ", lights->size(), " lights and ", receivers->size(),
        " receivers, need one of each (push with --floor, --receiver, --receiver-instance or "
        "--every-polygon makes receivers)"));
  }

  if (command.camera) {
    const absl::Status status =
        (*engine)->ReportView(command.scene_id, "watch", View{.camera = *command.camera});
    if (!status.ok()) return status;
  }
  UpdatePrinter printer(command, lights->size() * receivers->size(), console);
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  for (const std::string& receiver_id : *receivers) {
    for (const std::string& light_id : *lights) {
      const ArtifactSpec spec = SpecOf(command, light_id, receiver_id);
      auto subscription = (*engine)->SubscribeMeasured(
          command.scene_id, spec,
          [&printer, spec](const ArtifactUpdate& update, const UpdateTraffic& traffic) {
            printer.Print(spec, update, traffic);
          });
      if (!subscription.ok()) return subscription.status();
      subscriptions.push_back(*std::move(subscription));
    }
  }
  return printer.Wait(stop);
}

}  // namespace penumbra
