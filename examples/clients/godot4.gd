# Godot 4: a node that emits signals for key frames, moves, activity, steps, followed moves and poses. Not run here: there was no Godot 4.
# Start: mossar run SOURCE --to osc://127.0.0.1:9000   Attach to a Node, connect the signals to what reacts.
extends Node

signal key_frame(performer: String, status: String, kind: String, take: int, frame: int, time: float)
signal move(performer: String, status: String, name: String, limb: String)  # with --moves
signal activity(performer: String, channel: String, state: String)  # moving or resting
signal step(performer: String, status: String, side: String)  # with --steps: strike or off, left or right
signal follow(performer: String, status: String, name: String, count: int, progress: float)  # with --follow
signal pose(performer: String, status: String, name: String, seconds: float)  # entered, held or left

@export var port := 9000
var _socket := PacketPeerUDP.new()


func _ready() -> void:
	if _socket.bind(port, "127.0.0.1") != OK:
		push_error("port %d is in use" % port)


func _process(_delta: float) -> void:
	while _socket.get_available_packet_count() > 0:
		_receive(_socket.get_packet())


func _receive(packet: PackedByteArray) -> void:
	var stream := StreamPeerBuffer.new()
	stream.big_endian = true
	stream.data_array = packet
	var address := _text(stream)
	var arguments := []
	for type in _text(stream).substr(1):
		match type:
			"s": arguments.append(_text(stream))
			"i": arguments.append(stream.get_32())
			"f": arguments.append(stream.get_float())
	match address:
		"/mossar/key_frame":  # then decided_time, velocity, strength, rev
			key_frame.emit(arguments[0], arguments[1], arguments[2], arguments[3], arguments[4], arguments[5])
		"/mossar/move":  # then take, start, end, decided_time, score, rev
			move.emit(arguments[0], arguments[1], arguments[2], arguments[3])
		"/mossar/follow":  # performer, status, name, limb, joint, take, count, progress, then the rest of docs/events.md
			follow.emit(arguments[0], arguments[1], arguments[2], arguments[6], arguments[7])
		"/mossar/pose":  # performer, status, name, limb, joint, take, start, seconds, then the rest
			pose.emit(arguments[0], arguments[1], arguments[2], arguments[7])
		"/mossar/activity":  # then take, start, decided_time, previous
			activity.emit(arguments[0], arguments[1], arguments[2])
		"/mossar/step":  # then take, time, decided_time, confidence, x, y, z, id
			step.emit(arguments[0], arguments[1], arguments[2])


func _text(stream: StreamPeerBuffer) -> String:
	# OSC strings end with a zero and are filled up to a multiple of four bytes.
	var start := stream.get_position()
	var bytes := stream.data_array
	var end := bytes.find(0, start)
	stream.seek(start + (((end - start) / 4) + 1) * 4)
	return bytes.slice(start, end).get_string_from_utf8()
