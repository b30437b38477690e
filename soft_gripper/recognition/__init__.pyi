"""Recognition of the shape that is held."""

from .recognizer import ShapeRecognizer as ShapeRecognizer
from .shape_model import ShapeModel as ShapeModel
from .shape_model import grasp_features as grasp_features
from .shape_model import load_shape_model as load_shape_model
from .shape_model import save_shape_model as save_shape_model
from .shape_model import train_shape_model as train_shape_model
