"""The example of learning: a grasp that is as gentle as its estimates allow, and the hand-tuned one beside it."""
