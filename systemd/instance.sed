# Makes anogated@.service of anogated.service: an instance NAME has NAME.json and a runtime folder of its own.
s|^Description=.*|& %i|
s|/anogate\.json|/%i.json|
s|^ExecStart=.*|& --control /run/anogate-%i/control.sock|
s|^RuntimeDirectory=anogate$|RuntimeDirectory=anogate-%i\nEnvironment=XDG_RUNTIME_DIR=/run/anogate-%i|
