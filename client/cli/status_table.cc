#include "client/cli/status_table.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/server_json.h"
#include "client/session/utf8.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kNameColumns = 24;

// What has been counted between two answers, for each second.
class Rates {
 public:
  Rates(const Json* before, const Json& now)
      : before_(before),
        seconds_(before ? (NumberAt(now, "uptime_ms") - NumberAt(*before, "uptime_ms")) * 1e-3
                        : 0.0) {}

  // Whether there are any: not before the second answer, nor across a restart.
  bool exist() const { return before_ && seconds_ > 0; }

  double Of(const Json& before, const Json& now, const char* name) const {
    if (!exist()) return 0;
    return std::max(NumberAt(now, name) - NumberAt(before, name), 0.0) / seconds_;
  }

  // The entry of the answer before that has the same key; an empty one where there is none.
  Json Earlier(const char* list, const char* key, const Json& entry) const {
    if (!exist()) return Json::object();
    for (const Json& other : before_->value(list, Json::array())) {
      if (other.value(key, Json()) == entry.value(key, Json())) return other;
    }
    return Json::object();
  }

  std::string Text(double rate) const { return exist() ? absl::StrFormat("%.1f", rate) : "-"; }
  std::string BytesTextOf(double rate) const { return exist() ? BytesText(rate) : "-"; }

  const Json* before() const { return before_; }

 private:
  const Json* const before_;
  const double seconds_;
};

// A row, and what it is ranked by.
struct Row {
  double rank = 0;
  std::string text;
};

std::string Ranked(std::vector<Row> rows, size_t max_rows) {
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return a.rank > b.rank; });
  std::string text;
  for (size_t i = 0; i < std::min(rows.size(), max_rows); ++i) text += rows[i].text;
  if (rows.size() > max_rows) {
    absl::StrAppend(&text, "… and ", rows.size() - max_rows, " more\n");
  }
  return text;
}

Row SceneRow(const Json& scene, const Rates& rates) {
  const Json earlier = rates.Earlier("scenes", "scene_id", scene);
  const double edits = earlier.empty() ? 0 : rates.Of(earlier, scene, "revision");
  return {edits, absl::StrFormat("%s %10.0f %7.0f %9.0f %7.0f %7.0f %7.0f %9s\n",
                                 CellText(TextAt(scene, "scene_id"), kNameColumns),
                                 NumberAt(scene, "revision"), NumberAt(scene, "clients"),
                                 NumberAt(scene, "artifacts"), NumberAt(scene, "jobs_waiting"),
                                 NumberAt(scene, "jobs_running"), NumberAt(scene, "objects"),
                                 rates.Text(edits))};
}

Row ClientRow(const Json& client, const Rates& rates) {
  const Json earlier = rates.Earlier("clients", "session", client);
  const double bytes = rates.Of(earlier, client, "sent_bytes");
  return {bytes,
          absl::StrFormat(
              "%7.0f %s %s %11s %5.0f %9s %9s %9s %10s\n", NumberAt(client, "session"),
              CellText(TextAt(client, "client_name"), kNameColumns),
              CellText(TextAt(client, "scene_id"), kNameColumns),
              DurationText(NumberAt(client, "age_ms") * 1e-3), NumberAt(client, "subscriptions"),
              rates.Text(rates.Of(earlier, client, "commits")),
              rates.Text(rates.Of(earlier, client, "updates_sent")),
              rates.Text(rates.Of(earlier, client, "updates_skipped")), rates.BytesTextOf(bytes))};
}

std::string Total(const Json& now, const Rates& rates) {
  const Json statistics = now.value("statistics", Json::object());
  const Json earlier =
      rates.exist() ? rates.before()->value("statistics", Json::object()) : Json::object();
  const auto rate = [&](const char* name) { return rates.Of(earlier, statistics, name); };
  return absl::StrCat("a second: ", rates.Text(rate("commits")), " commits, ",
                      rates.Text(rate("jobs_started")), " jobs (", rates.Text(rate("jobs_failed")),
                      " failed), ", rates.Text(rate("updates_sent")), " updates (",
                      rates.Text(rate("updates_skipped")), " skipped), ",
                      rates.BytesTextOf(rate("sent_bytes")), "\n");
}

bool IsUnsafe(uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0xad || c == 0x61c ||
         (c >= 0x200b && c <= 0x200f) || (c >= 0x2028 && c <= 0x202e) ||
         (c >= 0x2060 && c <= 0x206f) || c == 0xfeff || (c >= 0xfff0 && c < 0xfffe);
}

}  // namespace

std::string CellText(std::string_view text, size_t columns) {
  std::vector<std::string> cells;
  while (!text.empty() && cells.size() <= columns) {
    const Utf8Character next = FirstUtf8(text);
    const bool is_shown = next.bytes > 0 && !IsUnsafe(next.character);
    cells.push_back(is_shown ? std::string(text.substr(0, next.bytes)) : "?");
    text.remove_prefix(std::max<size_t>(next.bytes, 1));
  }
  if (cells.size() > columns) {
    cells.resize(columns);
    if (columns > 0) cells.back() = "…";
  }
  std::string shown;
  for (const std::string& cell : cells) shown += cell;
  return shown.append(columns - cells.size(), ' ');
}

std::string DurationText(double seconds) {
  const auto whole = static_cast<int64_t>(std::max(seconds, 0.0));
  const std::string clock =
      absl::StrFormat("%02d:%02d:%02d", whole / 3600 % 24, whole / 60 % 60, whole % 60);
  const int64_t days = whole / 86'400;
  return days == 0 ? clock : absl::StrCat(days, " d ", clock);
}

std::string BytesText(double bytes) {
  const char* const units[] = {"B", "kB", "MB", "GB", "TB"};
  size_t unit = 0;
  for (; bytes >= 1000.0 && unit + 1 < std::size(units); ++unit) bytes /= 1000.0;
  return absl::StrFormat(unit == 0 ? "%.0f %s" : "%.1f %s", bytes, units[unit]);
}

std::string CountersText(const Json& statistics) {
  const auto count = [&](const char* name) {
    return absl::StrFormat("%.0f", NumberAt(statistics, name));
  };
  return absl::StrCat(count("open_sessions"), " sessions, ", count("open_subscriptions"),
                      " subscriptions, ", count("commits"), " commits, ", count("jobs_started"),
                      " jobs (", count("jobs_failed"), " failed), ", count("updates_sent"),
                      " updates sent (", count("updates_skipped"), " skipped), ",
                      BytesText(NumberAt(statistics, "sent_bytes")), " sent, ", count("blobs"),
                      " blobs (", BytesText(NumberAt(statistics, "blob_bytes")), ")");
}

std::string StatusTable(const std::string& address, const Json* before, const Json& now,
                        size_t max_rows) {
  const Rates rates(before, now);
  std::string text = absl::StrCat(TextAt(now, "server_name"), " at ", address,
                                  now.value("is_degraded", false) ? ", degraded" : "", ", up ",
                                  DurationText(NumberAt(now, "uptime_ms") * 1e-3), "\n",
                                  CountersText(now.value("statistics", Json::object())), "\n",
                                  Total(now, rates), "\n");
  std::vector<Row> scenes;
  for (const Json& scene : now.value("scenes", Json::array())) {
    scenes.push_back(SceneRow(scene, rates));
  }
  absl::StrAppend(&text, CellText("SCENE", kNameColumns),
                  "   REVISION CLIENTS ARTIFACTS WAITING RUNNING OBJECTS   EDITS/S\n",
                  Ranked(std::move(scenes), max_rows), "\n");
  std::vector<Row> clients;
  for (const Json& client : now.value("clients", Json::array())) {
    clients.push_back(ClientRow(client, rates));
  }
  absl::StrAppend(&text, "SESSION ", CellText("CLIENT", kNameColumns), " ",
                  CellText("SCENE", kNameColumns),
                  "         AGE  SUBS COMMITS/S UPDATES/S SKIPPED/S     SENT/S\n",
                  Ranked(std::move(clients), max_rows));
  if (const double left_out = NumberAt(now, "left_out"); left_out > 0) {
    absl::StrAppend(&text,
                    absl::StrFormat("… and %.0f that the answer had no room for\n", left_out));
  }
  return text;
}

}  // namespace penumbra
