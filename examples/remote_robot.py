"""Robot class for a Panda in another process, to adapt. Its side answers with plain numbers."""

from eyehand.data_synth.cell import make_robot
from eyehand.grasping import ArmReading, JawReading, JoinedRobot, load_hand


def remote_robot(connection, T_world_base):
    def ask(*request):
        connection.send(request)  # of multiprocessing.connection.Client((host, port))
        if not connection.poll(20.0):
            raise TimeoutError(f"no answer to {request[0]!r}")  # the pick ends with this fault
        return connection.recv()

    class Arm:
        joints, period = tuple(f"joint{number}" for number in range(1, 8)), 0.004

        def read(self):
            return ArmReading(*ask("state"))  # time, joint angles, velocities

        def step(self, velocity):
            return ArmReading(*ask("step", velocity))  # answers after one period

    class Hand:
        model = load_hand("panda")

        def read(self):
            return JawReading(*ask("width"))  # the width in m and, if it has one, the force in N

        def move(self, command):
            ask("move", command.width, command.force)

    class Camera:
        def capture(self):
            if frame := ask("capture"):  # a DepthFrame with its pose in the world
                return frame
            raise TimeoutError("the camera dropped a frame")  # the next one is tried

    kind = make_robot("panda")  # the description that the controller computes with
    parts = Arm(), Hand(), Camera(), lambda width: kind.description(kind.home, width, T_world_base)
    return JoinedRobot(*parts, kind.frame)
