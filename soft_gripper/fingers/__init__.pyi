"""The finger: its parameters, and the chain of links, springs and pressures that models it."""

from .cross_section import CrossSection as CrossSection
from .cross_section import Station as Station
from .finger import Finger as Finger
from .finger_parts import ContactMaterial as ContactMaterial
from .finger_parts import CreepBranch as CreepBranch
from .finger_parts import ElasticLaw as ElasticLaw
from .finger_parts import PressureLaw as PressureLaw
from .finger_parts import TipLoad as TipLoad
from .kinematics import as_planar as as_planar
from .kinematics import as_points as as_points
from .kinematics import forward_kinematics as forward_kinematics
from .kinematics import gravity_torque as gravity_torque
from .kinematics import in_space as in_space
from .plant_finger import PlantFinger as PlantFinger
from .pressure_drive import PressureDrive as PressureDrive
from .pressure_drive import pressure_torque_map as pressure_torque_map
from .statics import free_bending_angles as free_bending_angles
from .statics import resting_angles as resting_angles
