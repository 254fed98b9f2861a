#include <utility>

#include "proto/convert/spec_convert.h"
#include "server/service/penumbra_service.h"
#include "server/service/unary_call.h"

namespace penumbra {

grpc::ServerUnaryReactor* PenumbraService::ListTechniques(Context* context, const Bytes* request,
                                                          Bytes* response) {
  return AnswerUnary<v1::ListTechniquesRequest>(
      parts_, context, request, response,
      [](const v1::ListTechniquesRequest&,
         const Caller&) -> absl::StatusOr<v1::ListTechniquesResponse> {
        v1::ListTechniquesResponse list;
        for (auto& technique : AllTechniqueInfos()) *list.add_techniques() = std::move(technique);
        return list;
      });
}

}  // namespace penumbra
