#include "tests/fuzz/kit/message_mutator.h"

#include <algorithm>
#include <cstdint>
#include <memory>

#include "google/protobuf/descriptor.h"
#include "google/protobuf/unknown_field_set.h"
#include "tests/fuzz/kit/telling_values.h"

namespace penumbra::fuzzing {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

constexpr size_t kMostParts = 2'000;
constexpr size_t kMostWords = 200;
constexpr int kMostElements = 2'000;

std::vector<const FieldDescriptor*> FieldsOf(const Message& part) {
  std::vector<const FieldDescriptor*> fields;
  part.GetReflection()->ListFields(part, &fields);
  return fields;
}

// The message and everything in it.
void Collect(const Message& part, std::vector<const Message*>& parts) {
  if (parts.size() >= kMostParts) return;
  parts.push_back(&part);
  const Reflection& reflection = *part.GetReflection();
  for (const FieldDescriptor* field : FieldsOf(part)) {
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated()) {
      Collect(reflection.GetMessage(part, field), parts);
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(part, field); ++i) {
      Collect(reflection.GetRepeatedMessage(part, field, i), parts);
    }
  }
}

void CollectWords(const Message& part, std::vector<std::string>& words) {
  const Reflection& reflection = *part.GetReflection();
  for (const FieldDescriptor* field : FieldsOf(part)) {
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_STRING) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(part, field) : 1;
    for (int i = 0; i < count && words.size() < kMostWords; ++i) {
      std::string word = field->is_repeated() ? reflection.GetRepeatedString(part, field, i)
                                              : reflection.GetString(part, field);
      // Planes of numbers mean nothing elsewhere.
      if (word.size() <= 128) words.push_back(std::move(word));
    }
  }
}

bool IsText(const FieldDescriptor& field) { return field.type() == FieldDescriptor::TYPE_STRING; }

std::vector<std::string> TextsAmong(const std::vector<std::string>& words) {
  std::vector<std::string> texts;
  std::ranges::copy_if(words, std::back_inserter(texts), [](const std::string& word) {
    return std::ranges::all_of(word, [](char c) { return static_cast<int8_t>(c) >= 0; });
  });
  return texts;
}

void AddNested(google::protobuf::UnknownFieldSet& fields, int depth) {
  google::protobuf::UnknownFieldSet* inner = &fields;
  for (int i = 0; i < depth; ++i) inner = inner->AddGroup(1'000 + i);
  inner->AddVarint(1, 1);
}

}  // namespace

MessageMutator::MessageMutator(Draws& draws, std::span<const Message* const> donors)
    : draws_(draws) {
  for (const Message* donor : donors) Collect(*donor, parts_);
  for (const Message* part : parts_) CollectWords(*part, words_);
}

void MessageMutator::Mutate(Message& message) {
  for (uint64_t steps = 1 + draws_.Below(3); steps > 0; --steps) Step(message);
}

void MessageMutator::Step(Message& message) {
  std::vector<const Message*> own;
  Collect(message, own);
  // Parts of a message that may be changed may be.
  auto& part = const_cast<Message&>(*draws_.OneOf(own));
  const Descriptor& type = *part.GetDescriptor();
  if (draws_.OneIn(24)) return AddUnknownField(part);
  if (draws_.OneIn(6)) return Graft(part);
  if (type.field_count() == 0) return;
  const auto set = FieldsOf(part);
  const FieldDescriptor* field =
      set.empty() || draws_.OneIn(4)
          ? type.field(static_cast<int>(draws_.Below(type.field_count())))
          : draws_.OneOf(set);
  ChangeField(part, *field);
}

void MessageMutator::ChangeField(Message& part, const Field& field) {
  if (field.is_repeated()) return ChangeList(part, field);
  if (draws_.OneIn(8)) return part.GetReflection()->ClearField(&part, &field);
  ChangeSingular(part, field);
}

void MessageMutator::ChangeSingular(Message& part, const Field& field) {
  if (field.cpp_type() != Field::CPPTYPE_MESSAGE) return SetSingular(part, field);
  // Of a oneof this chooses the alternative.
  Message& inner = *part.GetReflection()->MutableMessage(&part, &field);
  if (draws_.OneIn(2)) Graft(inner);
}

void MessageMutator::ChangeList(Message& part, const Field& field) {
  const Reflection& reflection = *part.GetReflection();
  const int size = reflection.FieldSize(part, &field);
  const int at = static_cast<int>(draws_.Below(size)), other = static_cast<int>(draws_.Below(size));
  switch (draws_.Below(size == 0 ? 1 : 7)) {
    case 0:
      return AddElement(part, field);
    case 1:
      reflection.SwapElements(&part, &field, at, other);
      return;
    case 2:
      reflection.SwapElements(&part, &field, at, size - 1);
      return reflection.RemoveLast(&part, &field);
    case 3:
      if (draws_.OneIn(4)) return reflection.ClearField(&part, &field);
      return SetElement(part, field, at);
    case 4:  // many, alike
      for (uint64_t more = draws_.OneIn(8) ? 200 : 3; more > 0; --more) AddElement(part, field);
      return;
    default:
      return SetElement(part, field, at);
  }
}

void MessageMutator::AddElement(Message& part, const Field& field) {
  const Reflection& reflection = *part.GetReflection();
  const int size = reflection.FieldSize(part, &field);
  if (size >= kMostElements) return;
  switch (field.cpp_type()) {
    case Field::CPPTYPE_MESSAGE: {
      Message& added = *reflection.AddMessage(&part, &field);
      if (size > 0 && draws_.OneIn(2)) {
        const int from = static_cast<int>(draws_.Below(size));
        added.CopyFrom(reflection.GetRepeatedMessage(part, &field, from));
      } else {
        Graft(added);
      }
      return;
    }
    case Field::CPPTYPE_STRING:
      reflection.AddString(&part, &field, "");
      break;
    case Field::CPPTYPE_ENUM:
      return reflection.AddEnumValue(&part, &field, EnumNumber(field));
    case Field::CPPTYPE_FLOAT:
      reflection.AddFloat(&part, &field, 0);
      break;
    case Field::CPPTYPE_DOUBLE:
      reflection.AddDouble(&part, &field, 0);
      break;
    case Field::CPPTYPE_UINT32:
      reflection.AddUInt32(&part, &field, 0);
      break;
    case Field::CPPTYPE_INT32:
      reflection.AddInt32(&part, &field, 0);
      break;
    default:  // none of ours has others in lists
      return;
  }
  SetElement(part, field, size);
}

void MessageMutator::SetSingular(Message& part, const Field& field) {
  const Reflection& reflection = *part.GetReflection();
  switch (field.cpp_type()) {
    case Field::CPPTYPE_BOOL:
      return reflection.SetBool(&part, &field, !reflection.GetBool(part, &field));
    case Field::CPPTYPE_ENUM:
      return reflection.SetEnumValue(&part, &field, EnumNumber(field));
    case Field::CPPTYPE_FLOAT:
      return reflection.SetFloat(&part, &field,
                                 TellingReal(draws_, reflection.GetFloat(part, &field)));
    case Field::CPPTYPE_DOUBLE:
      return reflection.SetDouble(&part, &field,
                                  TellingReal(draws_, reflection.GetDouble(part, &field)));
    case Field::CPPTYPE_UINT32:
      return reflection.SetUInt32(
          &part, &field,
          static_cast<uint32_t>(TellingInteger(draws_, reflection.GetUInt32(part, &field))));
    case Field::CPPTYPE_INT32:
      return reflection.SetInt32(&part, &field, static_cast<int32_t>(TellingInteger(draws_, 0)));
    case Field::CPPTYPE_UINT64:
      return reflection.SetUInt64(&part, &field,
                                  TellingInteger(draws_, reflection.GetUInt64(part, &field)));
    case Field::CPPTYPE_INT64:
      return reflection.SetInt64(&part, &field, static_cast<int64_t>(TellingInteger(draws_, 0)));
    case Field::CPPTYPE_STRING: {
      const std::string now = reflection.GetString(part, &field);
      return reflection.SetString(&part, &field,
                                  IsText(field) ? TellingText(draws_, now, TextsAmong(words_))
                                                : TellingBytes(draws_, now, words_));
    }
    case Field::CPPTYPE_MESSAGE:
      return;
  }
}

void MessageMutator::SetElement(Message& part, const Field& field, int index) {
  const Reflection& reflection = *part.GetReflection();
  switch (field.cpp_type()) {
    case Field::CPPTYPE_MESSAGE:
      return Graft(*reflection.MutableRepeatedMessage(&part, &field, index));
    case Field::CPPTYPE_STRING: {
      const std::string now = reflection.GetRepeatedString(part, &field, index);
      return reflection.SetRepeatedString(&part, &field, index,
                                          IsText(field)
                                              ? TellingText(draws_, now, TextsAmong(words_))
                                              : TellingBytes(draws_, now, words_));
    }
    case Field::CPPTYPE_ENUM:
      return reflection.SetRepeatedEnumValue(&part, &field, index, EnumNumber(field));
    case Field::CPPTYPE_FLOAT:
      return reflection.SetRepeatedFloat(
          &part, &field, index,
          TellingReal(draws_, reflection.GetRepeatedFloat(part, &field, index)));
    case Field::CPPTYPE_DOUBLE:
      return reflection.SetRepeatedDouble(
          &part, &field, index,
          TellingReal(draws_, reflection.GetRepeatedDouble(part, &field, index)));
    case Field::CPPTYPE_UINT32: {
      const uint32_t now = reflection.GetRepeatedUInt32(part, &field, index);
      return reflection.SetRepeatedUInt32(&part, &field, index,
                                          static_cast<uint32_t>(TellingInteger(draws_, now)));
    }
    case Field::CPPTYPE_INT32:
      return reflection.SetRepeatedInt32(&part, &field, index,
                                         static_cast<int32_t>(TellingInteger(draws_, 0)));
    default:
      return;
  }
}

// Puts a part of the same type from elsewhere in its place.
void MessageMutator::Graft(Message& part) {
  std::vector<const Message*> alike;
  std::ranges::copy_if(parts_, std::back_inserter(alike), [&](const Message* donor) {
    return donor->GetDescriptor() == part.GetDescriptor();
  });
  if (!alike.empty()) part.CopyFrom(*draws_.OneOf(alike));
}

void MessageMutator::AddUnknownField(Message& part) {
  auto& fields = *part.GetReflection()->MutableUnknownFields(&part);
  const int number = static_cast<int>(1'000 + draws_.Below(1'000));
  switch (draws_.Below(4)) {
    case 0:
      return fields.AddVarint(number, TellingInteger(draws_, 0));
    case 1:
      return fields.AddFixed32(number, static_cast<uint32_t>(draws_.Bits()));
    case 2:
      return fields.AddLengthDelimited(number, TellingBytes(draws_, "", words_));
    default:
      return AddNested(fields, static_cast<int>(1 + draws_.Below(120)));
  }
}

int MessageMutator::EnumNumber(const Field& field) {
  const auto& type = *field.enum_type();
  if (draws_.OneIn(8)) return static_cast<int>(TellingInteger(draws_, 0));
  return type.value(static_cast<int>(draws_.Below(type.value_count())))->number();
}

}  // namespace penumbra::fuzzing
