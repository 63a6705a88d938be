#pragma once
// Private to CaseIO: checked access to JSON, with messages that name file and key.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "Core/Types.h"

namespace kerf::json_read {

using Json = nlohmann::json;

/// @throws InputError: cannot be opened, not JSON (with the position), not an object
Json ReadObject(const std::string& file);
/// Member of an object or null where absent.
const Json* Find(const Json& object, const std::string& key);
double Number(const Json& value, const std::string& file, const std::string& element);
int Integer(const Json& value, const std::string& file, const std::string& element);
std::string Text(const Json& value, const std::string& file, const std::string& element);
Vec3 Vector(const Json& value, const std::string& file, const std::string& element);

}  // namespace kerf::json_read
