// A client's assembler against a server that sends what it likes: common to the targets that differ
// in what is sent.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/artifact_assembler.h"
#include "tests/fuzz/kit/target.h"

namespace penumbra::fuzzing {

class ArtifactUpdates : public Target {
 public:
  std::span<const StepKind> kinds() const final { return kinds_; }
  void Run(const Script& script) final;

 protected:
  // Sound scripts: the artifact at once, in pieces, and with a change after it; its planes packed
  // and not.
  static std::vector<Seed> SeedsOf(const std::string& name, const Artifact& before,
                                   const Artifact& after);

 private:
  struct Delivered {
    std::shared_ptr<const Artifact> artifact;
    std::string bytes;
  };

  void Receive(const v1::ArtifactUpdate& message);

  const StepKind kinds_[1] = {{"update", &v1::ArtifactUpdate::default_instance()}};
  std::unique_ptr<ArtifactAssembler> assembler_;
  std::vector<Delivered> delivered_;
};

}  // namespace penumbra::fuzzing
