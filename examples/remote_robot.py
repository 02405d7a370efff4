"""Drivers of a Panda in another process. Its side answers each request with plain numbers."""

from eyehand.data_synth.cell import make_robot
from eyehand.grasping import ArmReading, JawReading, JoinedRobot, load_hand


class Link:
    def __init__(self, connection):
        self.connection = connection  # of multiprocessing.connection.Client((host, port))

    def ask(self, *request):
        self.connection.send(request)
        if not self.connection.poll(20.0):
            raise TimeoutError(f"no answer to {request[0]!r}")  # the pick ends with this fault
        return self.connection.recv()


class RemoteArm(Link):
    joints, period = tuple(f"joint{number}" for number in range(1, 8)), 0.004

    def read(self):
        return ArmReading(*self.ask("state"))  # time, joint angles, velocities

    def step(self, velocity):
        return ArmReading(*self.ask("step", velocity))  # answers after one period


class RemoteHand(Link):
    model = load_hand("panda")

    def read(self):
        return JawReading(*self.ask("width"))  # the width in m and, if it has one, the force in N

    def move(self, command):
        self.ask("move", command.width, command.force)


class RemoteCamera(Link):
    def capture(self):
        frame = self.ask("capture")  # a DepthFrame with its pose in the world
        if frame is None:
            raise TimeoutError("the camera dropped a frame")  # the next one is tried
        return frame


def remote_robot(connection, T_world_base):
    parts = RemoteArm(connection), RemoteHand(connection), RemoteCamera(connection)
    kind = make_robot("panda")  # the description that the controller computes with
    return JoinedRobot(
        *parts, lambda width: kind.description(kind.home, width, T_world_base), kind.frame
    )
