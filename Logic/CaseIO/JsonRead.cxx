#include "CaseIO/JsonRead.h"

#include <cmath>
#include <fstream>

#include "Core/Errors.h"

namespace kerf::json_read {

Json ReadObject(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "cannot be opened");
  Json json;
  try {
    json = Json::parse(in);
  } catch (const Json::parse_error& e) {
    throw InputError(file, "byte " + std::to_string(e.byte), "is not valid JSON");
  }
  if (!json.is_object()) throw InputError(file, "", "is not a JSON object");
  return json;
}

const Json* Find(const Json& object, const std::string& key) {
  const auto it = object.find(key);
  return it == object.end() || it->is_null() ? nullptr : &*it;
}

double Number(const Json& value, const std::string& file, const std::string& element) {
  if (!value.is_number()) throw InputError(file, element, "is not a number");
  const double number = value.get<double>();
  if (!std::isfinite(number)) throw InputError(file, element, "is not a finite number");
  return number;
}

int Integer(const Json& value, const std::string& file, const std::string& element) {
  const double number = Number(value, file, element);
  if (number != std::floor(number) || std::abs(number) > 2e9)
    throw InputError(file, element, "is not a whole number");
  return static_cast<int>(number);
}

std::string Text(const Json& value, const std::string& file, const std::string& element) {
  if (!value.is_string()) throw InputError(file, element, "is not a text");
  return value.get<std::string>();
}

Vec3 Vector(const Json& value, const std::string& file, const std::string& element) {
  if (!value.is_array() || value.size() != 3)
    throw InputError(file, element, "is not a list of three numbers");
  return {Number(value[0], file, element), Number(value[1], file, element),
          Number(value[2], file, element)};
}

}  // namespace kerf::json_read
