#include "Framework/qKerfHost.h"

qKerfHost::qKerfHost(QObject* parent) : QObject(parent) {}
qKerfHost::~qKerfHost() = default;
