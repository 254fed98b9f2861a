// Changes protobuf messages where they have a structure: fields are set to telling values, dropped,
// doubled and swapped, parts are taken from elsewhere, and fields that nobody knows are added.
//
//   MessageMutator mutator(draws, {&other_message});
//   mutator.Mutate(message);
//
// Debian 12 has no libprotobuf-mutator. This is what of it the targets here need.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "google/protobuf/message.h"
#include "tests/fuzz/kit/draws.h"

namespace penumbra::fuzzing {

class MessageMutator {
 public:
  // `donors`  what parts, texts and bytes are taken from, besides the message's own
  MessageMutator(Draws& draws, std::span<const google::protobuf::Message* const> donors);

  // Changes one to three places.
  void Mutate(google::protobuf::Message& message);

 private:
  using Message = google::protobuf::Message;
  using Field = google::protobuf::FieldDescriptor;

  void Step(Message& message);
  void ChangeField(Message& part, const Field& field);
  void ChangeSingular(Message& part, const Field& field);
  void ChangeList(Message& part, const Field& field);
  void AddElement(Message& part, const Field& field);
  void SetSingular(Message& part, const Field& field);
  void SetElement(Message& part, const Field& field, int index);
  void Graft(Message& part);
  void AddUnknownField(Message& part);
  int EnumNumber(const Field& field);

  Draws& draws_;
  std::vector<const Message*> parts_;  // of the donors and of the message itself
  std::vector<std::string> words_;     // that are in them
};

}  // namespace penumbra::fuzzing
