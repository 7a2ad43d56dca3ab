"""The protobuf schemas of the log and the code that protoc made of them."""
